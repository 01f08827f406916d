"""The amended simulator: the nominal one with the causes of a verdict, as a value and as YAML."""

from rallygap.models.ball.simulator import NODES, Simulator
from rallygap.models.gap.verdict import Cause, Verdict

CAMERA = "camera_distortion"


def amended(simulator: Simulator, verdict: Verdict, minor: bool = False) -> Simulator:
    """Return the simulator with the estimates of the main causes.

    Of a class of causes that the shots cannot separate it has the one that explains most.

    Args:
        simulator: the nominal one.
        verdict: with the causes.
        minor: whether minor structure is amended as well.
    """
    for cause in _amended_causes(verdict, minor):
        if cause.effect == CAMERA:
            simulator = _with_camera(simulator, verdict, cause.estimate)
            continue
        hypothesis = cause.hypothesis
        low, high = hypothesis.declaration.bounds
        simulator = hypothesis.at(simulator, min(max(cause.estimate, low), high))
    return simulator


def amended_yaml(simulator: Simulator, verdict: Verdict, data: str, minor: bool = False) -> str:
    """Return the amended simulator as YAML, with the origin of every change in a comment."""
    lines = []
    for effect, values in amended(simulator, verdict, minor).to_dict().items():
        changes = (one for one in _amended_causes(verdict, minor) if one.effect == effect)
        lines += [f"# {_origin(cause, verdict, data)}" for cause in changes]
        rows = values.pop(NODES, None)
        parameters = ", ".join(f"{name}: {value!r}" for name, value in values.items())
        if rows is None:
            lines.append(f"{effect}: {{{parameters}}}")
        else:
            lines += [f"{effect}:", *(f"  {name}: {value!r}" for name, value in values.items())]
            lines += [f"  {NODES}:", *(f"    - {row!r}" for row in rows)]
    return "\n".join(lines) + "\n"


def _with_camera(simulator: Simulator, verdict: Verdict, amplitude: float) -> Simulator:
    """Return the simulator with the cameras' error added to the one that it may have already."""
    if verdict.camera is None:
        return simulator
    known = simulator.effects.get(CAMERA, {})
    length, nodes = verdict.camera.length, [list(row) for row in verdict.camera.nodes]
    if known.get("length") == length:
        scale = known["amplitude"] / amplitude
        nodes += [[*row[:3], *(scale * weight for weight in row[3:])] for row in known[NODES]]
    return simulator.amended(CAMERA, amplitude=amplitude, length=length, nodes=nodes)


def _origin(cause: Cause, verdict: Verdict, data: str) -> str:
    before = f"{cause.nominal:g} before" if cause.kind == "wrong_value" else "missing before"
    low, high = cause.interval
    unit = "" if cause.unit == "1" else f" {cause.unit}"
    others = f"; not separable from {', '.join(cause.alternatives)}" if cause.alternatives else ""
    return (
        f"{cause.identity}: {before}; estimated {cause.estimate:.5g}{unit} from {data} "
        f"(95 % {low:.5g} to {high:.5g}); verdict {verdict.verdict}{others}"
    )


def _amended_causes(verdict: Verdict, minor: bool) -> tuple[Cause, ...]:
    return verdict.causes if minor else verdict.main_causes
