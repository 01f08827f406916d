"""How much of the recordings is used, and why the rest is not, in words."""

from collections.abc import Iterator

from rallygap.models.gap.verdict import Verdict
from rallygap.pipeline.gap.labels import LabelCounts
from rallygap.pipeline.gap.measured_shots import MeasuredShots


def usage_lines(measured: MeasuredShots) -> Iterator[str]:
    """Yield what is used and what is doubtful as lines of text."""
    yield f"Used: {episodes_text(measured)}. Spin labels: {labels_text(measured.labels)}."
    if len(measured.nets):
        yield f"Contacts with the net, with an arc before and after: {len(measured.nets):,}."
    for doubt in measured.doubts:
        yield f"Doubtful: {doubt}."


def with_doubts(verdict: Verdict, measured: MeasuredShots) -> Verdict:
    """Return the verdict with what is doubtful about the recordings among its limitations."""
    return verdict.model_copy(update={"limitations": (*measured.doubts, *verdict.limitations)})


def episodes_text(measured: MeasuredShots) -> str:
    """Return how many episodes are used, and why others are not."""
    used, recordings = len(measured.shots), measured.recordings
    text = f"{used:,} of {measured.episodes:,} episodes in {recordings:,} recordings"
    reasons = ", ".join(f"{count:,} {reason}" for reason, count in measured.left_out.items())
    return f"{text}; left out: {reasons}" if reasons else text


def labels_text(labels: LabelCounts) -> str:
    """Return how many spin labels are used, and why others are not."""
    if not labels.read:
        return "none"
    reasons = {"implausible": labels.implausible, "outside these episodes": labels.elsewhere}
    parts = [f"{count:,} {reason}" for reason, count in reasons.items() if count]
    text = f"{labels.used:,} of {labels.read:,}"
    return f"{text}; left out: {', '.join(parts)}" if parts else text
