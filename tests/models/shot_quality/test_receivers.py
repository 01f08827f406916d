"""Receivers: worse ones lose more points, and only the shots of the unchanged player count."""

import numpy as np
import pytest

from rallygap.models.arena.truth import draw_truth
from rallygap.models.shot_quality.receivers import RECEIVERS, Receiver, play_against
from rallygap.models.shot_quality.shots import FEATURES


def against(receiver):
    return play_against(receiver, draw_truth(3), 60, np.random.default_rng(2))


@pytest.fixture(scope="module")
def nominal():
    return against(RECEIVERS[0])


def test_shots_are_good_returns_in_the_frame_of_the_striking_player(nominal):
    features = dict(zip(FEATURES, nominal.features.T, strict=True))
    assert (features["along"] > 0).all()
    assert (features["vy"] > 0).all() and (features["vz"] < 0).all()
    assert (features["clearance"] > -0.03).all()


def test_at_most_the_last_shot_of_a_point_wins_it(nominal):
    assert nominal.point[nominal.wins].all()
    for match in np.unique(nominal.matches):
        rows = nominal.matches == match
        assert not nominal.wins[rows][:-1].any()
        assert len(set(nominal.point[rows])) == 1


@pytest.mark.parametrize(
    ("receiver", "more"),
    [(Receiver("inaccurate", error=4.0), 0.2), (Receiver("short", reach=0.05), 0.05)],
)
def test_a_worse_receiver_loses_more_points(nominal, receiver, more):
    assert against(receiver).wins.mean() > nominal.wins.mean() + more
