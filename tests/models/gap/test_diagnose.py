"""Diagnose: verdicts on shots whose cause is known."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.gap.amend.simulator import amended
from rallygap.models.gap.diagnose import diagnose
from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.refit import fit_nuisance
from rallygap.models.gap.fit.shots import held_out
from rallygap.models.gap.verify.limitations import UNSETTLED
from rallygap.models.gap.verify.prediction_error import HeldOut
from tests.models.gap.hidden import NOMINAL, SETTINGS, WITHOUT_MAGNUS, measured

SIDE = NOMINAL.amended("side_force", cy=0.02)


def named(verdict):
    return [(cause.identity, cause.kind) for cause in verdict.causes]


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
    assert side.phases.flight == pytest.approx(1.0)
    checks = {check.name: check for check in side.checks}
    assert set(checks) == {"residuals", "prediction", "landing", "labels"}
    assert side.misfits == ()
    assert checks["residuals"].ratio == pytest.approx(1.0, abs=0.05)


def test_an_effect_that_the_shots_do_not_have_is_a_main_cause_with_its_neutral_value():
    verdict = diagnose(measured(count=36), NOMINAL.amended("spin_decay", c=0.1))
    (cause,) = verdict.causes
    assert (cause.identity, cause.role, cause.estimate) == ("spin_decay.c", "leading", 0.0)


@pytest.mark.slow
def test_a_table_that_keeps_balls_and_missing_lift_are_named_together():
    dead = WITHOUT_MAGNUS.amended("table_bounce", restitution=0.0, friction=1.0)
    verdict = diagnose(measured(count=36), dead)
    found = {cause.identity: cause.estimate for cause in verdict.main_causes}
    bounce = {"table_bounce.restitution": 0.92, "table_bounce.friction": 0.25}
    assert found == pytest.approx({**bounce, "magnus.cm": 0.09}, rel=0.03)


def test_the_amended_simulator_predicts_like_the_true_one(side):
    shots, noise = measured(SIDE, count=30, seed=9), Noise(scatter=(0.01, 0.02, 0.005))
    about = fit_nuisance(shots, SIDE, noise, SETTINGS.fit)
    simulators = SIDE, amended(NOMINAL, side)
    held = HeldOut.of(about, shots, noise, SETTINGS)
    true, found, _ = held.errors(simulators, (150.0, 150.0), shots).squares
    assert np.nanmean(found) == pytest.approx(np.nanmean(true), rel=0.03)


def test_causes_that_do_not_settle_are_ambiguous():
    settings = replace(SETTINGS, name=replace(SETTINGS.name, max_rounds=0))
    shots = measured(NOMINAL.amended("side_force", cy=0.03), count=18, seed=1006)
    verdict = diagnose(shots, NOMINAL, settings)
    assert verdict.verdict == "ambiguous"
    assert [cause.possible for cause in verdict.causes] == [("side_force.cy",)]
    assert verdict.limitations[-1] == UNSETTLED


@pytest.mark.slow
def test_a_wrong_value_and_a_missing_effect_are_separated_in_one_set():
    truth = NOMINAL.amended("drag", cd=0.42).amended("table_height", h=0.006)
    verdict = diagnose(measured(truth, count=36), NOMINAL)
    assert sorted(named(verdict)) == [
        ("drag.cd", "wrong_value"),
        ("table_height.h", "missing_effect"),
    ]
    assert sum(cause.gap_share for cause in verdict.causes) == pytest.approx(1.0)


@pytest.mark.slow
def test_causes_that_look_alike_stay_ambiguous_with_the_experiment_that_separates_them():
    verdict = diagnose(measured(NOMINAL.amended("gravity", g=10.3), count=36), NOMINAL)
    assert verdict.verdict == "ambiguous"
    assert set(verdict.causes[0].possible) >= {"gravity.g", "buoyancy.b"}
    assert any("gravity.g is not separable from buoyancy.b" in one for one in verdict.limitations)


@pytest.mark.slow
def test_an_effect_that_the_catalogue_lacks_is_unknown_with_a_candidate_formula():
    verdict = diagnose(measured(SIDE, count=48), NOMINAL, withheld=("side_force",))
    assert verdict.verdict == "unknown"
    assert verdict.unexplained.phase == "flight"
    assert "side" in verdict.unexplained.formula
    assert "side_force.cy" not in verdict.minimum_detectable


@pytest.mark.slow
def test_flipped_labels_are_named():
    shots = measured(count=36)
    sign = np.where(np.arange(36) % 5 == 0, -1.0, 1.0)[:, None, None]
    verdict = diagnose(replace(shots, labels=shots.labels * sign), NOMINAL)
    assert named(verdict) == [("spin_sign_flip.share", "missing_effect")]
    assert verdict.causes[0].interval[0] < 8 / 36 < verdict.causes[0].interval[1]


@pytest.mark.slow
def test_missing_lift_is_named_without_spin_labels():
    verdict = diagnose(measured(count=45, labels=None), WITHOUT_MAGNUS)
    assert ("magnus.cm", "missing_effect") in named(verdict)
    assert "gravity.g" not in {cause.identity for cause in verdict.causes}


@pytest.mark.parametrize("flipped", [0, pytest.param(8, marks=pytest.mark.slow)])
def test_missing_lift_is_named_with_spin_labels(flipped):
    shots = measured(count=45 if flipped else 24)
    shots.labels[:flipped] *= -1.0
    verdict = diagnose(shots, WITHOUT_MAGNUS)
    effects = {cause.effect for cause in verdict.causes}
    assert verdict.verdict == "named"
    assert effects == ({"magnus", "spin_sign_flip"} if flipped else {"magnus"})


def test_whole_recordings_are_held_out():
    groups = np.repeat(np.arange(10), 3)
    held = held_out(replace(measured(count=30), groups=groups), SETTINGS)
    assert 3 * 3 <= held.sum() <= 4 * 3
    assert all(len(set(held[groups == group])) == 1 for group in range(10))


def test_too_few_shots_are_refused():
    with pytest.raises(ValueError, match="2 shots are too few"):
        diagnose(measured(count=2), NOMINAL)
