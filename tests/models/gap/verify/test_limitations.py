"""Limitations: what data cannot decide, with the experiment that would."""

import pytest

from rallygap.models.gap.verdict import DetectionLimits
from rallygap.models.gap.verify.limitations import experiment, limitations
from tests.models.gap.hidden import SETTINGS, measured
from tests.models.gap.test_verdict import WIND


def like(*names):
    return WIND.model_copy(update={"possible": names})


def one_way(shots):
    return shots[shots.positions[:, -1, 1] > shots.positions[:, 0, 1]]


def test_missing_data_are_named():
    shots = one_way(measured(count=24, labels=None))
    no_table = DetectionLimits({}, ("table_bounce.restitution", "table_bounce.friction"))
    found = limitations(shots, [], no_table, True, SETTINGS)
    assert [
        any(part in one for one in found)
        for part in ("12 shots", "no spin", "one direction", "no bounces")
    ] == [True] * 4


def test_an_estimate_at_its_bound_is_the_limitation_of_good_data():
    at_bound = like("wind.y").model_copy(update={"estimate": 10.0})
    absent = like("spin_decay.c").model_copy(update={"identity": "spin_decay.c", "estimate": 0.0})
    causes = [like("wind.y"), at_bound, absent]
    blind = DetectionLimits({}, ("time_offset.tau",))
    (found,) = limitations(measured(count=24), causes, blind, True, SETTINGS)
    assert found.startswith("wind.y: 10 ")


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
    assert wanted in experiment(like(*names), shots if way == 2 else one_way(shots), SETTINGS)
