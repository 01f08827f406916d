"""Limits: what data cannot decide is said in words, with the experiment that would."""

import pytest

from models.gap.verify.limitations import experiment, limits
from tests.models.gap.hidden import measured
from tests.models.gap.test_verdict import WIND


def like(*names):
    return WIND.model_copy(update={"possible": names})


def one_way(shots):
    return shots[shots.positions[:, -1, 1] > shots.positions[:, 0, 1]]


def test_good_data_have_no_limits():
    assert limits(measured(count=24), [], ["time_offset"]) == ()


def test_what_is_missing_is_named():
    said = limits(one_way(measured(count=24, labels=None)), [], ["restitution", "friction"])
    assert [
        any(part in one for one in said)
        for part in ("12 shots", "no spin", "both ways", "no bounces")
    ] == [True] * 4


def test_estimates_at_their_bounds_are_doubted():
    inside = like("wind")
    at_bound = inside.model_copy(update={"estimate": 3.0, "interval": (2.1, 3.0), "unit": "m/s"})
    said = limits(measured(count=24), [inside, at_bound], [])
    assert len(said) == 1
    assert said[0].startswith("wind: 3 m/s is the end")


@pytest.mark.parametrize(
    ("names", "labels", "way", "wanted"),
    [
        (("gravity", "clock_rate"), "rows", 2, "same cameras"),
        (("wind", "frame_tilt"), "rows", 1, "both ways"),
        (("magnus", "lift_saturation"), None, 2, "measure the spin"),
        (("magnus", "spin_decay"), "one", 2, "after the bounce"),
        (("gravity", "buoyancy"), "rows", 2, "weigh the ball"),
        (("restitution", "speed_dependent_restitution"), "rows", 2, "wider range of falls"),
        (("drag", "linear_drag"), "rows", 2, "range of speeds"),
    ],
)
def test_every_class_has_an_experiment(names, labels, way, wanted):
    shots = measured(count=6, labels=labels)
    shots = shots if way == 2 else one_way(shots)
    assert wanted in experiment(like(*names), shots)
