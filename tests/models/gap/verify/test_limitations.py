"""Limitations: what data cannot decide, with the experiment that would."""

import pytest

from rallygap.models.gap.name.label_readings import LabelReadings
from rallygap.models.gap.verdict import DetectionLimits
from rallygap.models.gap.verify.limitations import experiment, limitations, of_labels
from tests.models.gap.hidden import SETTINGS, measured
from tests.models.gap.test_verdict import WIND


def like(*names):
    return WIND.model_copy(update={"possible": names})


def limits(*not_identifiable):
    return DetectionLimits({}, not_identifiable)


def one_way(shots):
    return shots[shots.positions[:, -1, 1] > shots.positions[:, 0, 1]]


def test_missing_data_are_named():
    shots = one_way(measured(count=24, labels=None))
    no_table = limits("table_bounce.restitution", "table_bounce.friction")
    found = limitations(shots, [], no_table, True, SETTINGS)
    assert [
        any(part in one for one in found)
        for part in ("12 shots", "no spin", "one direction", "no bounces")
    ] == [True] * 4


def test_estimates_at_their_bounds_are_the_limitations_of_good_data():
    inside = like("wind.y")
    at_bound = inside.model_copy(update={"estimate": 10.0, "interval": (9.1, 10.0), "unit": "m/s"})
    absent = {"identity": "spin_decay.c", "nominal": 0.1, "estimate": 0.0, "interval": (0.0, 0.001)}
    causes = [inside, at_bound, like("spin_decay.c").model_copy(update=absent)]
    blind = limits("time_offset.tau")
    (found,) = limitations(measured(count=24), causes, blind, True, SETTINGS)
    assert found.startswith("wind.y: 10 m/s is the bound")


@pytest.mark.parametrize("way", [1, 2])
def test_an_error_of_the_cameras_looks_like_other_errors_of_places(way):
    camera = WIND.model_copy(
        update={
            "identity": "camera_distortion.amplitude",
            "possible": ("camera_distortion.amplitude",),
            "role": "sensor",
            "estimate": 0.0025,
        }
    )
    shots = measured(count=48 if way == 1 else 24)
    found = limitations(one_way(shots) if way == 1 else shots, [camera], limits(), True, SETTINGS)
    (one,) = (sentence for sentence in found if sentence.startswith("camera_distortion"))
    assert "2.5 mm, it is not separable from position_scale, frame_tilt, table_height" in one
    assert ("wind, drag and lift" in one) == (way == 1)


@pytest.mark.parametrize(
    ("names", "labels", "way", "wanted"),
    [
        (("gravity.g", "clock_rate.d"), "rows", 2, "same cameras"),
        (("wind.x", "frame_tilt.x"), "rows", 1, "both directions"),
        (("magnus.cm", "lift_saturation.kappa"), None, 2, "measure the spin"),
        (("magnus.cm", "spin_decay.c"), "one", 2, "after the bounce"),
        (("gravity.g", "buoyancy.b"), "rows", 2, "weigh the ball"),
        (("table_bounce.friction", "table_tilt.x"), "rows", 2, "wider range of impact"),
        (("drag.cd", "linear_drag.k1"), "rows", 2, "range of speeds"),
    ],
)
def test_every_class_has_an_experiment(names, labels, way, wanted):
    shots = measured(count=6, labels=labels)
    shots = shots if way == 2 else one_way(shots)
    assert wanted in experiment(like(*names), shots, SETTINGS)


def test_labels_that_are_not_used_are_limitations():
    flipped, outliers = frozenset({1}), frozenset({2, 5})
    (found,) = of_labels(LabelReadings(flipped, 30, SETTINGS, outliers))
    assert found == "2 of 30 spin labels are outliers and not used"
    (found,) = of_labels(LabelReadings(frozenset(), 30, SETTINGS, useless=True))
    assert found.startswith("spin labels err by more than half of the spin")
    assert of_labels(LabelReadings(flipped, 30, SETTINGS)) == ()
