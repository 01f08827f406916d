"""Numbers, shares, p-values, phases and roles as text."""

from collections.abc import Sequence

from rallygap.models.gap.types import Phase
from rallygap.models.gap.verdict import Role, Worth
from rallygap.pipeline.web.numbers import number

PLACES: dict[Phase, str] = {
    "flight": "in flight",
    "table": "at the table",
    "sensor": "in the measurement",
}
ROLES: dict[Role, str] = {
    "leading": "leading cause",
    "sensor": "sensor fault",
    "minor": "minor structure",
}
SMALLEST_P = 1e-3
MOST_LISTED = 3  # names in a sentence; tables list all


def interval_text(interval: tuple[float, float]) -> str:
    """Return both ends of an interval."""
    return f"{number(interval[0])} to {number(interval[1])}"


def percent(share: float) -> str:
    """Return a share in percent."""
    return f"{100 * share:.0f} %"


def p_text(p_value: float) -> str:
    """Return a p-value as in a sentence, such as ``p = 0.02``."""
    return f"p < {SMALLEST_P:g}" if p_value < SMALLEST_P else f"p = {p_value:.2g}"


def listed(names: Sequence[str]) -> str:
    """Return the names in a row, or how many there are where a sentence cannot hold them."""
    return ", ".join(names) if len(names) <= MOST_LISTED else f"{len(names)} other parameters"


def worth_text(worth: Worth) -> str:
    """Return what a cause is worth alone, such as ``5.3 mm more (95 % 2.8 to 7.9)``."""
    low, high = worth.interval
    if worth.mm >= 0.0:
        return f"{worth.mm:.1f} mm more (95 % {low:.1f} to {high:.1f})"
    return f"{-worth.mm:.1f} mm less (95 % {-high:.1f} to {-low:.1f})"


def counted(count: int, noun: str) -> str:
    """Return a number of things, such as ``2 leading causes``."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
