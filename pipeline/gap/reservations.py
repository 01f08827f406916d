"""Reservations about a verdict: checks that fail, and amended predictions that are worse."""

from collections.abc import Iterator

import numpy as np

from rallygap.models.gap.verdict import Check, Gap, Verdict

# What each check compares, where its ratio is that of measured and expected sizes.
COMPARED = {
    "residuals": "residuals of held-out shots are {} times as large as it expects",
    "prediction": "predictions err {} times as much as it expects",
    "landing": "predicted landings err {} times as much as it expects",
}
DOUBTFUL = {
    "residuals": "intervals and p-values",
    "prediction": "intervals and small causes",
    "landing": "causes at the table",
    "labels": "causes that rest on spin labels",
    "bounces": "causes at the table",
}


def reservations(verdict: Verdict) -> Iterator[str]:
    """Yield what speaks against relying on a verdict, one sentence or two each."""
    if verdict.misfits:
        found = "; ".join(_misfit(check) for check in verdict.misfits)
        doubtful = ", ".join(dict.fromkeys(DOUBTFUL[check.name] for check in verdict.misfits))
        yield (
            f"The fitted model does not describe these shots: {found}. Do not rely on {doubtful}."
        )
    if verdict.gap and verdict.gap.reduction_mm and predicts_worse(verdict):
        low, high = verdict.gap.reduction_mm
        yield (
            f"The amended simulator predicts worse than the nominal one: held-out predictions err "
            f"{_growth(verdict.gap):.1f} mm more, mean over horizons (95 % {-high:.1f} to "
            f"{-low:.1f}). Do not use amended.yaml."
        )


def predicts_worse(verdict: Verdict) -> bool:
    """Return whether amended predictions are significantly worse than nominal ones."""
    reduction = verdict.gap.reduction_mm if verdict.gap else None
    return reduction is not None and reduction[1] < 0.0


def _growth(gap: Gap) -> float:
    return float(np.mean(gap.after_mm) - np.mean(gap.before_mm))


def _misfit(check: Check) -> str:
    low, high = check.allowed
    if check.name == "labels":
        return (
            f"spin labels err by {100 * check.ratio:.0f} % of the spin (allowed {100 * high:g} %)"
        )
    if check.name == "bounces":
        return (
            f"the restitution differs by {check.ratio:.2g} from bounce to bounce (allowed {high:g})"
        )
    found = COMPARED[check.name].format(f"{check.ratio:.3g}")
    interval = f"{check.interval[0]:.3g} to {check.interval[1]:.3g}"
    return f"{found} (95 % {interval}; allowed {low:.3g} to {high:.3g})"
