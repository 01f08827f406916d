"""The methods of the exam on recordings without noise, and the gap workflow's answer."""

import pytest

from experiments.exam.interface import rounded, shots_of
from experiments.exam.methods.registry import METHODS
from experiments.exam.simulate.recordings import simulate_trial
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.gap.diagnose import diagnose
from tests.experiments.exam.example_trials import NOMINAL, recorded, trial

WIND = {
    "sindy": (0.1, 0.03),
    "sindy_ensemble": (0.1, 0.03),
    "evidence_greedy": (0.1, 0.03),
    "identification": (0.5, 1e-3),
}


def answer(method, effect=None, parameter="", value=0.0, withheld=(), **settings):
    """Return the answer to recordings without noise."""
    return METHODS[method](recorded(effect, parameter, value, **settings), NOMINAL, withheld)


@pytest.mark.parametrize("method", WIND)
def test_a_large_effect_in_flight_is_named_without_noise(method):
    size, tolerance = WIND[method]
    found = answer(method, "wind", "x", size)
    assert (found.conclusion, [cause.identity for cause in found.causes]) == ("named", ["wind.x"])
    (cause,) = found.causes
    assert cause.estimate == pytest.approx(size, rel=tolerance)
    assert cause.interval is None or cause.interval[0] <= cause.estimate <= cause.interval[1]
    assert rounded(found.amended.effects["wind"]["x"]) == cause.estimate


@pytest.mark.parametrize(
    ("method", "effect", "parameter", "value", "labels", "tolerance"),
    [
        *(
            (method, *cause, "per_row", 0.05)
            for method in ("sindy", "evidence_greedy")
            for cause in (
                ("table_bounce", "restitution", 0.90),
                ("table_tilt", "y", 0.01),
                ("spin_axis_bias", "z", 0.2),
            )
        ),
        ("sindy", "table_tilt", "y", 0.01, "none", 0.05),
        ("identification", "table_bounce", "restitution", 0.90, "per_row", 1e-3),
    ],
)
def test_effects_of_the_table_and_of_labels_are_named(
    method, effect, parameter, value, labels, tolerance
):
    found = answer(method, effect, parameter, value, spin_labels=labels)
    assert found.causes[0].identity == f"{effect}.{parameter}"
    assert found.causes[0].estimate == pytest.approx(value, rel=tolerance)


@pytest.mark.parametrize("method", WIND)
def test_nothing_is_named_without_a_gap_and_a_withheld_effect_never(method):
    assert answer(method).conclusion == "no_gap"
    found = answer(method, "wind", "x", WIND[method][0], withheld=("wind",))
    assert "wind.x" not in {name for cause in found.causes for name in cause.possible}


@pytest.mark.slow
def test_the_workflows_answer_is_its_verdict():
    asked = trial(shots=30, seed=1004, causes={"table_bounce": {"restitution": 0.80}})
    recordings, _ = simulate_trial(asked)
    found = METHODS["rallygap"](recordings, NOMINAL, ("wind",))
    verdict = diagnose(shots_of(recordings), NOMINAL, withheld=("wind",))
    named, cause = found.causes[0], verdict.causes[0]
    assert named.identity == "table_bounce.restitution"
    assert (found.conclusion, named.possible) == (verdict.verdict, cause.possible)
    assert named.estimate == rounded(cause.estimate)
    assert named.interval == tuple(rounded(end) for end in cause.interval)
    assert found.amended == amended(NOMINAL, verdict)
