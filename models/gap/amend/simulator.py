"""Amend: the simulator with the causes that a verdict names, and where they come from."""

from collections.abc import Iterator

from models.ball.simulator import Simulator
from models.gap.verdict import Cause, Verdict, hypothesis_of


def amended(simulator: Simulator, verdict: Verdict) -> Simulator:
    """Return the simulator with the estimates of all causes in it.

    Of causes that the shots cannot tell apart it takes the one that explains most, since on balls
    like these any does as well. Causes with which it predicts other shots worse are left out.
    """
    for cause in _taken(verdict):
        simulator = hypothesis_of(cause, simulator).at(simulator, _within_bounds(simulator, cause))
    return simulator


def amended_yaml(simulator: Simulator, verdict: Verdict, data: str) -> str:
    """Return the amended simulator's YAML; every change says where it comes from.

    Args:
        simulator: as it was.
        verdict: on it.
        data: name of the data set.
    """
    result = amended(simulator, verdict)
    notes: dict[str, list[str]] = {}
    for cause in _taken(verdict):
        effect = hypothesis_of(cause, simulator).effect
        notes.setdefault(effect, []).append(provenance(cause, verdict, data))
    return "\n".join(_lines(result, notes)) + "\n"


def provenance(cause: Cause, verdict: Verdict, data: str) -> str:
    """Return in words where an amendment comes from."""
    was = f"was {cause.nominal:g}" if cause.kind == "wrong_value" else "was missing"
    low, high = cause.interval
    doubt = f"; could be {', '.join(cause.others)}" if cause.others else ""
    return (
        f"{cause.parameter}: {was}; {data} says {cause.estimate:.5g} {cause.unit} "
        f"(95 % {low:.5g} to {high:.5g}); verdict {verdict.verdict}{doubt}"
    )


def _taken(verdict: Verdict) -> tuple[Cause, ...]:
    return () if verdict.gap and verdict.gap.worse else verdict.effects


def _lines(simulator: Simulator, notes: dict[str, list[str]]) -> Iterator[str]:
    for effect, values in simulator.to_dict().items():
        yield from (f"# {note}" for note in notes.get(effect, []))
        yield f"{effect}: {{{', '.join(f'{name}: {value!r}' for name, value in values.items())}}}"


def _within_bounds(simulator: Simulator, cause: Cause) -> float:
    low, high = hypothesis_of(cause, simulator).declaration.bounds
    return min(max(cause.estimate, low), high)
