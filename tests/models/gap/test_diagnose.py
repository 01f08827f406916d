"""Diagnose: verdicts on shots whose cause is known."""

from dataclasses import replace

import numpy as np
import pytest

from models.gap.amend.simulator import amended
from models.gap.diagnose import diagnose
from models.gap.fit.noise import Noise
from models.gap.fit.refit import fit_nuisance
from models.gap.fit.split import held_out
from models.gap.verify.prediction_error import errors
from tests.models.gap.hidden import NOMINAL, SETTINGS, WITHOUT_MAGNUS, measured

SIDE = NOMINAL.amended("side_force", cy=0.02)


def named(verdict):
    return [(one.identity, one.kind) for one in verdict.causes]


@pytest.fixture(scope="module")
def side():
    return diagnose(measured(SIDE, count=36), NOMINAL)


def test_no_cause_is_named_where_there_is_none():
    verdict = diagnose(measured(count=36, seed=3), NOMINAL)
    assert (verdict.verdict, verdict.causes) == ("no_gap", ())
    assert verdict.minimum_detectable["drag.cd"] == pytest.approx(0.01, rel=1.0)
    assert set(verdict.not_identifiable) >= {"buoyancy.b", "time_offset.tau"}


def test_a_missing_effect_is_named_with_its_size(side):
    assert side.verdict == "named"
    assert named(side) == [("side_force.cy", "missing_effect")]
    cause = side.causes[0]
    assert cause.interval[0] < 0.02 < cause.interval[1]
    assert (cause.possible, cause.nominal) == (("side_force.cy",), 0.0)
    assert side.phases.flight == 1.0


def test_amending_what_was_named_brings_predictions_to_the_truth(side):
    fresh, noise = measured(SIDE, count=30, seed=9), Noise(scatter=(0.01, 0.02, 0.005))
    about = fit_nuisance(fresh, SIDE, noise, settings=SETTINGS.fit)
    found = errors(about, SIDE, amended(NOMINAL, side), noise, (150.0, 150.0), settings=SETTINGS)
    assert np.nanmean(found.after) == pytest.approx(np.nanmean(found.before), rel=0.03)


@pytest.mark.slow
def test_a_wrong_value_and_a_missing_effect_are_told_apart_in_one_set():
    hall = NOMINAL.amended("drag", cd=0.42).amended("table_height", h=0.006)
    verdict = diagnose(measured(hall, count=36), NOMINAL)
    assert sorted(named(verdict)) == [
        ("drag.cd", "wrong_value"),
        ("table_height.h", "missing_effect"),
    ]
    assert sum(one.gap_share for one in verdict.causes) == pytest.approx(1.0)


@pytest.mark.slow
def test_causes_that_look_alike_are_left_open_with_the_experiment_that_splits_them():
    verdict = diagnose(measured(NOMINAL.amended("gravity", g=10.3), count=36), NOMINAL)
    assert verdict.verdict == "ambiguous"
    assert set(verdict.causes[0].possible) >= {"gravity.g", "buoyancy.b"}
    assert any("gravity.g or buoyancy.b" in one for one in verdict.limitations)


@pytest.mark.slow
def test_an_effect_that_the_catalogue_lacks_is_unknown_and_has_a_lead():
    shots = measured(SIDE, count=48)
    verdict = diagnose(shots, NOMINAL, withheld=("side_force",))
    assert verdict.verdict == "unknown"
    assert verdict.unexplained.phase == "flight"
    assert "side" in verdict.unexplained.formula
    assert "side_force.cy" not in verdict.minimum_detectable


@pytest.mark.slow
def test_backward_labels_are_named():
    shots = measured(count=36)
    turn = np.where(np.arange(36) % 5 == 0, -1.0, 1.0)[:, None, None]
    verdict = diagnose(replace(shots, labels=shots.labels * turn), NOMINAL)
    assert named(verdict) == [("spin_sign_flip.share", "missing_effect")]
    assert verdict.causes[0].interval[0] < 8 / 36 < verdict.causes[0].interval[1]


@pytest.mark.slow
def test_missing_lift_is_named_where_nobody_measured_the_spin():
    verdict = diagnose(measured(count=45, labels=None), WITHOUT_MAGNUS)
    assert ("magnus.cm", "missing_effect") in named(verdict)
    assert "gravity.g" not in {one.identity for one in verdict.causes}
    assert any("no spin labels" in one for one in verdict.limitations)


@pytest.mark.parametrize("flipped", [0, pytest.param(8, marks=pytest.mark.slow)])
def test_a_simulator_without_lift_lacks_it_where_spins_are_labelled(flipped):
    shots = measured(count=45)
    shots.labels[:flipped] *= -1.0
    verdict = diagnose(shots, WITHOUT_MAGNUS)
    names = [one.effect for one in verdict.causes if one.effect != "spin_sign_flip"]
    assert (verdict.verdict, names) == ("named", ["magnus"])
    assert len(verdict.causes) == (2 if flipped else 1)


def test_whole_recordings_are_held_out():
    shots = measured(count=30)
    groups = np.repeat(np.arange(10), 3)
    held = held_out(replace(shots, groups=groups))
    assert 3 * 3 <= held.sum() <= 4 * 3
    assert all(len(set(held[groups == one])) == 1 for one in range(10))


def test_too_few_shots_are_refused():
    with pytest.raises(ValueError, match="2 shots are too few"):
        diagnose(measured(count=2), NOMINAL)
