"""Amended simulators as close_gap would leave them."""

from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.amend.simulator import amended_yaml
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.verdict import Cause
from rallygap.pipeline.io.amended_simulators import case_name
from rallygap.pipeline.io.artifacts import write_text
from tests.pipeline.verdicts import verdict


def causes(base, changes):
    """The causes behind ``changes`` to a shipped simulator."""
    numbers = [(effect, one) for effect, values in changes.items() for one in values]
    return [
        _cause(Hypothesis(*number), shipped(base), changes[number[0]][number[1]])
        for number in numbers
    ]


def _cause(hypothesis, simulator, estimate):
    return Cause(
        identity=hypothesis.identity,
        kind="wrong_value" if hypothesis.listed(simulator) else "missing_effect",
        unit=hypothesis.declaration.unit,
        nominal=hypothesis.value(simulator),
        estimate=estimate,
        interval=(estimate - 0.01, estimate + 0.01),
        p_value=1e-5,
        gap_share=0.5,
        possible=(hypothesis.identity,),
    )


def write_amended(folder, source, base, changes, split=0):
    """Write what balls of ``source`` made of a shipped simulator; return the verdict."""
    found = verdict(causes=causes(base, changes))
    path = folder / case_name(source, base, split)
    write_text(path.with_suffix(".yaml"), amended_yaml(shipped(base), found, source))
    write_text(path.with_suffix(".json"), found.to_json())
    return found
