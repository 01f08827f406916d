"""Receivers: better ones lose fewer points, and only the others' shots count."""

import numpy as np
import pytest

from models.arena.truth import draw_truth
from models.shot_quality.receivers import RECEIVERS, Receiver, played_against
from models.shot_quality.shots import FEATURES

POINTS = 60


def against(receiver, points=POINTS):
    return played_against(receiver, draw_truth(3), points, np.random.default_rng(2))


@pytest.fixture(scope="module")
def usual():
    return against(RECEIVERS[0])


def test_shots_are_good_returns_in_the_strikers_frame(usual):
    told = dict(zip(FEATURES, usual.features.T, strict=True))
    assert (told["along"] > 0).all() and (told["vy"] > 0).all() and (told["vz"] < 0).all()
    assert (told["clearance"] > -0.03).all()


def test_a_point_is_won_by_one_shot_at_most_and_only_the_last(usual):
    assert usual.point[usual.wins].all()
    for match in np.unique(usual.matches):
        own = usual.matches == match
        assert not usual.wins[own][:-1].any()
        assert len(set(usual.point[own])) == 1


def test_who_errs_much_loses_more_often(usual):
    wild = against(Receiver("wild", error=4.0))
    assert wild.wins.mean() > usual.wins.mean() + 0.2


def test_who_hardly_reaches_loses_more_often(usual):
    short = against(Receiver("short", reach=0.05))
    assert short.wins.mean() > usual.wins.mean() + 0.05


def test_the_usual_receiver_is_changed_by_a_third_each_way(usual):
    factors = {(one.reach, one.error) for one in RECEIVERS if one.draw == 0}
    assert factors == {(1, 1), (2 / 3, 1), (4 / 3, 1), (1, 2 / 3), (1, 4 / 3)}
    assert [(one.reach, one.error) for one in RECEIVERS if one.draw] == [(1, 1)]
    again = against(RECEIVERS[0])
    assert (again.features == usual.features).all() and (again.wins == usual.wins).all()
