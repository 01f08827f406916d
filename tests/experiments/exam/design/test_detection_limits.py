"""Detection limits, compared with what the workflow finds without knowing noise and launches."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from experiments.exam.design.detection_limits import DetectionLimits
from experiments.exam.interface import shots_of
from experiments.exam.simulate.camera_errors import CameraErrors, Distortion, LabelErrors, Stamps
from experiments.exam.simulate.recordings import simulate_trial
from experiments.exam.simulate.trial import CAMERAS
from rallygap.models.gap.fit.refit import refit
from rallygap.models.gap.hypotheses import LABEL_SIGNS, Hypothesis
from rallygap.models.gap.inference.score_test import Evidence
from rallygap.models.gap.settings import GapSettings
from tests.experiments.exam.example_trials import NOMINAL, trial

WIND, GRAVITY, BUOYANCY, ADDED_MASS, HEIGHT, TILT = map(
    Hypothesis.from_identity,
    ("wind.x", "gravity.g", "buoyancy.b", "added_mass.c", "table_height.h", "spin_axis_bias.x"),
)
USUAL = {"shots": 20, "seed": 1001}


@cache
def limits(**settings):
    return DetectionLimits.of(trial(**{**USUAL, **settings}))


def test_they_are_what_the_workflow_finds_with_noise_and_scatter_estimated():
    recordings, _ = simulate_trial(trial(**USUAL))
    settings = GapSettings()
    fitted = refit(shots_of(recordings), NOMINAL, (), settings.fit)
    evidence = Evidence.of(fitted.linear, fitted.noise_estimate, settings)
    others = (Hypothesis("drag", "cd"), Hypothesis("spin_decay", "c"), HEIGHT)
    for parameter in (WIND, GRAVITY, *others):
        k = evidence.columns.index(parameter)
        expected = evidence.minimum_detectable_effect(k, [j for j in evidence.free if j != k])
        assert limits().minimum_sizes((parameter,)) == pytest.approx([expected], rel=0.15)


def test_they_follow_the_noise_and_not_the_causes():
    expected = limits().minimum_sizes((WIND,))
    noisy = limits(cameras=replace(CAMERAS, position_noise=0.010))
    windy = DetectionLimits.of(trial(**USUAL, causes={"wind": {"x": 1.0}}))
    assert windy.minimum_sizes((WIND,)) == expected
    assert noisy.minimum_sizes((WIND,))[0] > 1.5 * expected[0]


def test_indistinguishable_parameters_leave_nothing_detectable():
    wind, gravity, buoyancy, mass = sizes(WIND, GRAVITY, BUOYANCY, ADDED_MASS)
    rivals = limits().indistinguishable
    assert np.isfinite(buoyancy)
    assert "gravity.g" in rivals(BUOYANCY, 3 * buoyancy)
    assert "buoyancy.b" in rivals(GRAVITY, 100 * gravity)
    assert rivals(WIND, 0.5 * wind) != ()
    assert rivals(WIND, 100 * wind) == rivals(LABEL_SIGNS, 0.1) == ()
    # Two nominal parameters together may explain a missing effect.
    assert rivals(ADDED_MASS, 3 * mass) == ("drag.cd", "gravity.g")
    assert rivals(ADDED_MASS, 30 * mass) == ()


def test_a_withheld_effect_is_separated_from_all_others_and_flipped_labels_need_labels():
    assert replace(limits(), withheld=("wind",)).minimum_sizes((WIND,))[0] > sizes(WIND)
    assert replace(limits(), withheld=("buoyancy",)).minimum_sizes((BUOYANCY,)) == [np.inf]
    assert sizes(LABEL_SIGNS) == 4 / 20
    assert (sizes(LABEL_SIGNS, Hypothesis("spin_gain", "s"), spin_labels="none") == np.inf).all()


def sizes(*parameters, **settings):
    found = limits(**settings)
    return np.array([found.minimum_sizes((one,))[0] for one in parameters])


def test_a_distortion_hides_what_looks_like_it_the_more_the_larger_it_is():
    plain = sizes(WIND, HEIGHT)
    small, large, far = (
        sizes(WIND, HEIGHT, errors=CameraErrors(distortion=Distortion("gaussian", size, length)))
        for size, length in ((0.0001, 1.0), (0.004, 1.0), (0.004, 50.0))
    )

    assert plain == pytest.approx(small, rel=0.3)
    assert (large > 1.5 * small).all()
    # A constant shift of heights is nearly a field of a long correlation length.
    assert far[1] == pytest.approx(5.8 * 0.004, rel=0.2)


def test_errors_that_rows_share_and_of_time_stamps_hide_more_than_independent_ones():
    rows = sizes(TILT)
    shots = sizes(TILT, errors=CameraErrors(labels=LabelErrors(shot=0.05)))
    one_label = sizes(TILT, spin_labels="per_shot")
    exact = replace(CAMERAS, spin_noise=0.0)
    arcs = sizes(TILT, cameras=exact, errors=CameraErrors(labels=LabelErrors(arc=0.05)))
    sessions = sizes(TILT, errors=CameraErrors(labels=LabelErrors(session=0.3)))

    assert rows < sessions
    assert rows < arcs < one_label
    assert rows < shots < one_label
    assert sizes(WIND) < sizes(WIND, errors=CameraErrors(stamps=Stamps(jitter=0.002)))
