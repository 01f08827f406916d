"""What to do after a verdict."""

from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.settings import GapSettings
from rallygap.models.gap.verdict import Verdict
from rallygap.models.gap.verify.limitations import experiment
from rallygap.pipeline.gap.reservations import predicts_worse
from rallygap.pipeline.gap.wording import PLACES, listed

CHECK_LABELS = "check signs, axes and units of the spin labels, and diagnose again."
CHECK_BOUNCES = (
    "let one ball bounce at one place, then at others, then other balls; diagnose those that "
    "bounce alike by themselves."
)
CHECK_RECORDINGS = (
    "look for errors of the recordings, such as outliers, wrong time stamps or an old "
    "calibration, and diagnose again."
)
KEEP_NOMINAL = (
    "keep the nominal simulator. Record more shots at other speeds and spins, and diagnose again."
)
CONFIRM = "predict with amended.yaml, and diagnose new recordings with it to confirm the causes."
SPLIT = (
    "look for what changes between shots, such as balls, air or cameras, and diagnose the parts of "
    "the session by themselves. No constant value closes this gap."
)
UNSETTLED = (
    "record more shots at other speeds and spins, and measure spins; until then, amended.yaml is "
    "one of several possible simulators."
)


def next_step(verdict: Verdict, shots: Shots, settings: GapSettings) -> str:
    """Return what to do next, in one or two sentences."""
    if predicts_worse(verdict):
        return KEEP_NOMINAL
    if verdict.misfits:
        names = {check.name for check in verdict.misfits}
        single = names.pop() if len(names) == 1 else ""
        return {"labels": CHECK_LABELS, "bounces": CHECK_BOUNCES}.get(single, CHECK_RECORDINGS)
    if verdict.verdict == "no_gap":
        return _nothing_to_amend(shots, settings)
    if verdict.verdict == "unknown":
        return _missing_effect(verdict)
    return CONFIRM if verdict.verdict == "named" else _separate(verdict, shots, settings)


def _nothing_to_amend(shots: Shots, settings: GapSettings) -> str:
    few = settings.verify.few_shots
    if len(shots) < few:
        return f"nothing to amend. Record {few} shots or more to detect smaller effects."
    return "nothing to amend. More shots would detect smaller effects."


def _missing_effect(verdict: Verdict) -> str:
    phase = verdict.unexplained.phase
    if verdict.variations and not phase:
        return SPLIT
    where = f" {PLACES[phase]}" if phase else ""
    return (
        f"the catalogue lacks an effect{where}; add one (docs/add-an-effect.md), and diagnose "
        "again. The candidate formula is a hint."
    )


def _separate(verdict: Verdict, shots: Shots, settings: GapSettings) -> str:
    cause = next((one for one in verdict.main_causes if one.ambiguous), None)
    if cause is None:
        return UNSETTLED
    others = listed(cause.alternatives)
    return (
        f"predict with amended.yaml; to tell {cause.identity} from {others}, "
        f"{experiment(cause, shots, settings)}."
    )
