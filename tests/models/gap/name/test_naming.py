"""Name: many causes at once, and none that is not there."""

from dataclasses import replace

import numpy as np
import pytest

from models.arena.truth import draw_truth
from models.ball.simulator import Simulator
from models.ball.simulators import shipped
from models.gap import diagnose as diagnosis
from models.gap.diagnose import diagnose
from models.gap.fit.refit import refit
from models.gap.name import naming
from models.gap.name.label_signs import find_flipped_labels
from models.gap.name.naming import Question, name
from models.gap.name.selection import Explainer, Explanation, evidence_about
from models.gap.verify.limitations import UNSETTLED
from tests.models.gap.hidden import NOMINAL, SETTINGS, measured

SIX = {
    "drag": {"cd": 0.42},
    "wind": {"x": 0.3},
    "side_force": {"cy": 0.025},
    "spin_dependent_drag": {"c": 0.1},
    "table_height": {"h": 0.006},
    "table_tilt": {"y": 0.0075},
}


def ball_and_table(simulator):
    """A simulator without what no unbroken shot meets."""
    effects = simulator.to_dict()
    rackets = ("racket_bounce", "net")
    return Simulator.from_dict({name: effects[name] for name in effects if name not in rackets})


def test_six_causes_at_ten_times_their_size_are_all_named():
    some = replace(SETTINGS, name=replace(SETTINGS.name, first_shots=30))  # then all once more
    hall = NOMINAL
    for effect, values in SIX.items():
        hall = hall.amended(effect, **values)
    found = name(measured(hall, count=40, seed=1005), Question(NOMINAL, some))
    columns = found.explainer.evidence.columns
    causes = [columns[k] for k in found.explanation.causes]
    assert sorted(one.identity for one in causes) == [
        "drag.cd", "side_force.cy", "spin_dependent_drag.c",
        "table_height.h", "table_tilt.y", "wind.x",
    ]  # fmt: skip
    for one in causes:
        assert one.value(found.simulator) == pytest.approx(one.value(hall), rel=0.15)


def test_causes_that_do_not_stay_are_ambiguous(monkeypatch):
    none = replace(SETTINGS, name=replace(SETTINGS.name, max_rounds=0))
    monkeypatch.setattr(diagnosis, "GapSettings", lambda level: none)
    hall = NOMINAL.amended("side_force", cy=0.03)
    verdict = diagnose(measured(hall, count=18, seed=1006), NOMINAL)
    assert verdict.verdict == "ambiguous"
    assert [one.possible for one in verdict.causes] == [("side_force.cy",)]
    assert verdict.limitations[-1] == UNSETTLED


@pytest.mark.parametrize("labels", ["rows", "one"])
def test_a_clock_that_runs_slow_is_neither_gravity_nor_backward_labels(labels):
    """Gravity and a spin sensor's gain do the work of such a clock; labels seem to contradict."""
    slow = NOMINAL.amended("clock_rate", d=-0.18)
    shots = measured(slow, count=24, seed=1, labels=labels)
    assert find_flipped_labels(
        shots, refit(shots, NOMINAL, (), settings=SETTINGS.fit), settings=SETTINGS
    ).significant
    found = name(shots, Question(NOMINAL, SETTINGS))
    assert not found.signs.flipped
    assert [one.effect for one in found.fit.free] == ["clock_rate"]
    assert found.simulator.to_dict()["clock_rate"]["d"] == pytest.approx(-0.18, abs=0.001)


def test_values_that_make_no_sense_promise_nothing():
    """More lift than in the simulator would be a saturation below nothing."""
    found = refit(
        measured(NOMINAL.amended("magnus", cm=0.15), count=20), NOMINAL, (), settings=SETTINGS.fit
    )
    explainer = Explainer(evidence_about(found, NOMINAL, settings=SETTINGS), NOMINAL)
    places = {one.identity: k for k, one in enumerate(explainer.evidence.columns)}
    lift, saturation = (places[one] for one in ("magnus.cm", "lift_saturation.kappa"))
    assert explainer.gain((saturation,)) == -np.inf
    hopeless, right = (Explanation((k,), {k: 0.0}) for k in (saturation, lift))
    trial = naming._as_promised(explainer, right, found)
    assert trial is not None and [one.effect for one in trial.free] == ["magnus"]
    assert naming._as_promised(explainer, hopeless, found) is None


def test_backward_labels_are_told_beside_a_cause():
    shots = measured(NOMINAL.amended("gravity", g=10.6), count=24, seed=2)
    turn = np.ones((24, 1, 1))
    turn[[2, 5, 11, 17]] = -1.0
    found = name(replace(shots, labels=shots.labels * turn), Question(NOMINAL, SETTINGS))
    assert found.signs.flipped == {2, 5, 11, 17}
    assert [one.effect for one in found.fit.free] == ["gravity"]


@pytest.mark.slow
def test_the_causes_of_a_hall_are_named_and_no_others():
    hall = ball_and_table(draw_truth(1001).simulator)
    nominal = ball_and_table(shipped("imperfect_c"))
    verdict = diagnose(measured(hall, count=90, seed=1001), nominal)
    listed = nominal.to_dict()
    wrong = [one for one in verdict.causes if one.effect not in (*hall.effects, *listed)]
    assert not wrong
    assert len(verdict.causes) >= 9
    assert verdict.gap.removable_closed == pytest.approx(1.0, abs=0.15)
