"""Numbers as text."""


def number(value: float) -> str:
    """Return a number with four significant digits."""
    return f"{value:.4g}"


def with_unit(value: float, unit: str) -> str:
    """Return a number with its unit, if it has one."""
    return number(value) if unit == "1" else f"{number(value)} {unit}"


def interval_text(interval: tuple[float, float]) -> str:
    """Return both ends of an interval."""
    return f"{number(interval[0])} to {number(interval[1])}"
