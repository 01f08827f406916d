"""Amended simulators as close_gap would leave them."""

from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.amend.simulator import amended_yaml
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.pipeline.io.amended_simulators import case_name
from rallygap.pipeline.io.artifacts import write_text
from tests.pipeline.verdicts import cause, verdict


def causes(base, changes):
    """The causes behind ``changes`` to a shipped simulator."""
    numbers = [(effect, *one) for effect, values in changes.items() for one in values.items()]
    return [_cause(Hypothesis(*number), shipped(base), value) for *number, value in numbers]


def _cause(hypothesis, simulator, value):
    kind = "wrong_value" if hypothesis.listed(simulator) else "missing_effect"
    values = (hypothesis.value(simulator), value, value - 0.01, value + 0.01)
    return cause(hypothesis.identity, hypothesis.declaration.unit, values, 1e-5, 0.5, kind=kind)


def write_amended(folder, source, base, changes, split=0):
    """Write what balls of ``source`` made of a shipped simulator; return the verdict."""
    found = verdict(causes=causes(base, changes))
    path = folder / case_name(source, base, split)
    write_text(path.with_suffix(".yaml"), amended_yaml(shipped(base), found, source))
    write_text(path.with_suffix(".json"), found.to_json())
    return found
