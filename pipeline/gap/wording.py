"""Parts of a verdict as text: numbers, shares, causes, and what is used of the recordings."""

from collections.abc import Mapping, Sequence

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.types import Phase
from rallygap.models.gap.verdict import Cause, Role, Variation, Worth
from rallygap.pipeline.gap.measured_shots import LabelCounts, MeasuredShots
from rallygap.pipeline.web.numbers import number, with_unit

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


def title(identity: str) -> str:
    """Return the catalogue's description of the effect of a parameter."""
    return catalogue()[Hypothesis.from_identity(identity).effect].title


def cause_sentence(cause: Cause) -> str:
    """Return a cause with its estimate, share and worth."""
    estimate = f"{with_unit(cause.estimate, cause.unit)} (95 % {interval_text(cause.interval)})"
    missing = cause.kind == "missing_effect"
    before = "missing in the simulator" if missing else f"simulator {number(cause.nominal)}"
    share = f"{percent(cause.gap_share)} of the gap"
    worth = f"; without it predictions err {worth_text(cause.worth)}" if cause.worth else ""
    others = f" Not separable from {listed(cause.alternatives)}." if cause.alternatives else ""
    return (
        f"{ROLES[cause.role].capitalize()} {cause.identity} ({title(cause.identity)}): "
        f"estimate {estimate}, {before}; {share}{worth}.{others}"
    )


def variation_sentence(variation: Variation) -> str:
    """Return a parameter that is not the same in all shots, with the size of its variation."""
    size = f"{with_unit(variation.size, variation.unit)} (95 % {interval_text(variation.interval)})"
    what = {
        "drift": f"drifts over the session, by {size} from the first shot to the last",
        "by_side": f"is larger where y > 0 than where y < 0, by {size}",
        "between_shots": f"differs from shot to shot, with a standard deviation of {size}",
    }[variation.kind]
    others = variation.possible[1:]
    tail = f" Not separable from {listed(others)}." if others else ""
    return f"{variation.identity} ({title(variation.identity)}) {what}; not amended.{tail}"


def episodes_text(measured: MeasuredShots) -> str:
    """Return how many episodes are used, and why others are not."""
    used, recordings = len(measured.shots), measured.recordings
    text = f"{used:,} of {measured.episodes:,} episodes in {recordings:,} recordings"
    return _with_reasons(text, measured.left_out)


def labels_text(labels: LabelCounts) -> str:
    """Return how many spin labels are used, and why others are not."""
    if not labels.read:
        return "none"
    reasons = {"implausible": labels.implausible, "outside these episodes": labels.elsewhere}
    return _with_reasons(f"{labels.used:,} of {labels.read:,}", reasons)


def reasons_text(counts: Mapping[str, int]) -> str:
    """Return counts with their reasons, such as ``2 broken, 1 too short``."""
    return ", ".join(f"{count:,} {reason}" for reason, count in counts.items() if count)


def _with_reasons(text: str, counts: Mapping[str, int]) -> str:
    reasons = reasons_text(counts)
    return f"{text}; left out: {reasons}" if reasons else text
