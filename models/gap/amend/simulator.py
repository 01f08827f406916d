"""The amended simulator: the nominal one with the causes of a verdict, as a value and as YAML."""

from models.ball.simulator import Simulator
from models.gap.verdict import Cause, Verdict


def amended(simulator: Simulator, verdict: Verdict) -> Simulator:
    """Return the simulator with the estimates of all causes.

    Of a class of causes that the shots cannot separate it has the one that explains most. Causes
    with which held-out predictions are worse are left out.
    """
    for cause in _accepted(verdict):
        hypothesis = cause.hypothesis
        low, high = hypothesis.declaration.bounds
        simulator = hypothesis.at(simulator, min(max(cause.estimate, low), high))
    return simulator


def amended_yaml(simulator: Simulator, verdict: Verdict, data: str) -> str:
    """Return the amended simulator as YAML, with the origin of every change in a comment."""
    lines = []
    for effect, values in amended(simulator, verdict).to_dict().items():
        changes = (one for one in _accepted(verdict) if one.effect == effect)
        lines += [f"# {_origin(cause, verdict, data)}" for cause in changes]
        parameters = ", ".join(f"{name}: {value!r}" for name, value in values.items())
        lines.append(f"{effect}: {{{parameters}}}")
    return "\n".join(lines) + "\n"


def _origin(cause: Cause, verdict: Verdict, data: str) -> str:
    before = f"{cause.nominal:g} before" if cause.kind == "wrong_value" else "missing before"
    low, high = cause.interval
    unit = "" if cause.unit == "1" else f" {cause.unit}"
    others = f"; not separable from {', '.join(cause.alternatives)}" if cause.alternatives else ""
    return (
        f"{cause.identity}: {before}; estimated {cause.estimate:.5g}{unit} from {data} "
        f"(95 % {low:.5g} to {high:.5g}); verdict {verdict.verdict}{others}"
    )


def _accepted(verdict: Verdict) -> tuple[Cause, ...]:
    return () if verdict.gap and verdict.gap.worse else verdict.causes
