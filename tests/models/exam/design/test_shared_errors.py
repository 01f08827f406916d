"""Errors that all shots share reduce the information as a random effect does."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.exam.design.detection_limits import DetectionLimits
from rallygap.models.exam.simulate.camera_errors import (
    CameraErrors,
    Distortion,
    LabelErrors,
    Stamps,
)
from rallygap.models.exam.simulate.trial import CAMERAS
from rallygap.models.gap.hypotheses import Hypothesis
from tests.models.exam.example_trials import trial

WIND, HEIGHT, TILT = (
    Hypothesis("wind", "x"),
    Hypothesis("table_height", "h"),
    Hypothesis("spin_axis_bias", "x"),
)


def sizes(*parameters, **settings):
    limits = DetectionLimits.of(trial(shots=20, seed=1001, **settings))
    return np.array([limits.minimum_sizes((one,))[0] for one in parameters])


def with_errors(**errors):
    return {"errors": CameraErrors(**errors)}


def test_a_distortion_hides_what_looks_like_it_the_more_the_larger_it_is():
    plain = sizes(WIND, HEIGHT)
    small, large = (
        sizes(WIND, HEIGHT, **with_errors(distortion=Distortion("gaussian", size, 1.0)))
        for size in (0.0001, 0.004)
    )

    assert plain == pytest.approx(small, rel=0.3)
    assert (large > 1.5 * small).all()
    # A constant shift of heights is nearly a field of a long correlation length.
    far = sizes(HEIGHT, **with_errors(distortion=Distortion("gaussian", 0.004, 50.0)))
    assert far == pytest.approx(5.8 * 0.004, rel=0.2)


def test_label_errors_that_rows_share_hide_more_than_independent_ones():
    rows = sizes(TILT)
    shots = sizes(TILT, **with_errors(labels=LabelErrors(shot=0.05)))
    one_label = sizes(TILT, spin_labels="per_shot")
    exact = replace(CAMERAS, spin_noise=0.0)
    arcs = sizes(TILT, cameras=exact, **with_errors(labels=LabelErrors(arc=0.05)))
    sessions = sizes(TILT, **with_errors(labels=LabelErrors(session=0.3)))

    assert rows < sessions
    assert rows < arcs < one_label
    assert rows < shots < one_label


def test_errors_of_time_stamps_hide_causes():
    assert sizes(WIND) < sizes(WIND, **with_errors(stamps=Stamps(jitter=0.002)))
