"""Numbers as text."""

SIGNIFICANT = 0.05  # p-value up to which something is reported
SMALLEST_P = 1e-3  # that a sentence states


def number(value: float) -> str:
    """Return a number with four significant digits."""
    return f"{value:.4g}"


def with_unit(value: float, unit: str) -> str:
    """Return a number with its unit, if it has one."""
    return number(value) if unit == "1" else f"{number(value)} {unit}"


def interval_text(interval: tuple[float, float]) -> str:
    """Return both ends of an interval."""
    return f"{number(interval[0])} to {number(interval[1])}"


def percent(share: float) -> str:
    """Return a share in percent."""
    return f"{100 * share:.0f} %"


def p_text(p_value: float) -> str:
    """Return a p-value as in a sentence, such as ``p = 0.02``."""
    return f"p < {SMALLEST_P:g}" if p_value < SMALLEST_P else f"p = {p_value:.2g}"
