"""Landings of shots: closed forms, returns, measured samples, and games against receivers."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.arena.truth import draw_truth
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.simulators import shipped
from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.outcome import judge
from rallygap.models.predictors.windows import Episode
from rallygap.models.shot_quality.receivers import RECEIVERS, Receiver, play_against
from rallygap.models.shot_quality.shots import (
    FEATURES,
    clearance,
    has_first_arc,
    landings,
    measured_landing,
    shot_features,
    stroke_direction,
)

VACUUM = Simulator.from_dict(
    {"gravity": {"g": 9.81}, "table_bounce": {"restitution": 0.9, "friction": 0.25}}
)
STRUCK = np.array([[0.1, -1.5, 0.3, 0.2, 5.0, 1.5, -100.0, 20.0, 10.0]])


def test_without_air_a_ball_lands_where_a_parabola_does():
    fall = STRUCK[0, 2] - BALL_RADIUS
    time = (1.5 + np.sqrt(1.5**2 + 2 * 9.81 * fall)) / 9.81
    expected = [0.1 + 0.2 * time, -1.5 + 5 * time, BALL_RADIUS, 0.2, 5.0, 1.5 - 9.81 * time]
    assert landings(VACUUM, STRUCK)[0] == pytest.approx([*expected, -100.0, 20.0, 10.0], abs=1e-6)


def test_returns_land_where_their_evaluation_says():
    simulator = shipped("literature")
    random = np.random.default_rng(0)
    after = STRUCK + random.normal(scale=[0.1, 0.1, 0.1, 0.5, 1, 1, 50, 20, 20], size=(300, 9))
    outcome = judge(simulator, after, Goals(np.zeros((300, 2))))
    returned = outcome.returned
    assert returned.sum() > 50
    landed = landings(simulator, after[returned])
    assert (landed[:, :2] == outcome.landing[returned]).all()
    assert np.abs(landed[:, 2] - BALL_RADIUS).max() < 1e-6
    assert clearance(outcome.net_height[returned]).min() > -0.03  # over the cord at the lowest


def test_features_omit_the_height_at_the_bounce_and_clearance_counts_from_the_net():
    (row,) = shot_features(np.arange(9.0)[None], np.array([0.5]))
    assert row.tolist() == [0, 1, 3, 4, 5, 6, 7, 8, 0.5]
    assert clearance(np.array([0.1725])) == pytest.approx([0.0])


START = np.array([0.2, -1.5, 0.35, -0.3, 6.0, 1.0])  # m, m/s
SPIN = np.array([-120.0, 15.0, 4.0])
BOUNCE = (START[5] + np.sqrt(START[5] ** 2 + 2 * 9.81 * (START[2] - BALL_RADIUS))) / 9.81
TIMES = 2.0 + 0.005 * np.arange(int(BOUNCE / 0.005) + 1)


def fallen(seconds):
    """Positions and velocities of the ball some seconds after its stroke."""
    down = np.outer(seconds, [0, 0, -9.81])
    velocities = START[3:] + down
    return START[:3] + np.outer(seconds, START[3:]) + down * seconds[:, None] / 2, velocities


def stroke(direction=1):
    positions, velocities = fallen(TIMES - 2.0)
    turn = np.array([direction, direction, 1.0])
    spins = np.tile(SPIN * turn, (len(TIMES), 1))
    nothing = np.zeros(len(TIMES), dtype=int)
    return Episode(
        TIMES, positions * turn, velocities * turn, spins, nothing == 1, nothing,
        np.array([2.0 + BOUNCE]),
    )  # fmt: skip


@pytest.mark.parametrize("direction", [1, -1])
def test_a_stroke_lands_where_the_parabola_does_in_either_direction(direction):
    state, height = measured_landing(stroke(direction))
    place, velocity = (one[0] for one in fallen(np.array([BOUNCE])))
    assert stroke_direction(stroke(direction)) == direction
    assert state == pytest.approx(np.concatenate([place, velocity, SPIN]), abs=1e-9)
    assert state[2] == pytest.approx(BALL_RADIUS)
    at_net = fallen(np.array([1.5 / 6.0]))[0][0, 2]
    assert height == pytest.approx(at_net, abs=1e-3)  # four samples within 15 ms


def test_outliers_do_not_count():
    one, marked = stroke(), TIMES[-1] == TIMES
    wrong = one.positions + 0.3 * marked[:, None]
    state, _ = measured_landing(replace(one, positions=wrong, outlier=marked))
    assert state == pytest.approx(measured_landing(one)[0], abs=1e-9)


def test_a_ball_that_does_not_touch_the_other_half_first_or_has_no_valid_sample_is_no_return():
    one = stroke()
    assert measured_landing(replace(one, bounces=np.empty(0))) is None
    early = replace(one, bounces=np.array([2.1]), arc=(TIMES > 2.1).astype(int))
    assert measured_landing(early) is None  # comes down on the striker's own half
    touched = replace(one, arc=(TIMES > 2.3).astype(int))  # something else came before the table
    assert measured_landing(touched) is None
    invalid = replace(one, outlier=np.ones(len(TIMES), dtype=bool))
    assert has_first_arc(one) and not has_first_arc(invalid)
    assert measured_landing(invalid) is None


def test_a_sample_at_the_very_moment_of_the_bounce_is_after_it():
    one = stroke()
    rows = ("times", "positions", "velocities", "spins", "outlier", "arc")
    again = [*range(len(TIMES)), -1]
    longer = {name: getattr(one, name)[again] for name in rows}
    longer["times"][-1], longer["arc"][-1] = one.bounces[0], 1
    assert measured_landing(replace(one, **longer))[0] == pytest.approx(measured_landing(one)[0])


def against(receiver):
    return play_against(receiver, draw_truth(3), 60, np.random.default_rng(2))


@pytest.fixture(scope="module")
def nominal():
    return against(RECEIVERS[0])


def test_shots_are_good_returns_and_at_most_the_last_of_a_point_wins_it(nominal):
    features = dict(zip(FEATURES, nominal.features.T, strict=True))
    assert (features["along"] > 0).all()
    assert (features["vy"] > 0).all() and (features["vz"] < 0).all()
    assert (features["clearance"] > -0.03).all()
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
