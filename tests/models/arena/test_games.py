"""Games: by the rules, at the level of their players."""

from collections import Counter
from itertools import pairwise

import numpy as np
import pytest

from tests.models.arena.sessions import LEVELS, games, of_group


def points_of(level=None):
    recordings = games() if level is None else of_group(level)
    return [(recording, point) for recording in recordings for point in recording.points]


def contacts_of(recording, point):
    """Return kinds and states of what changed the ball until the point was decided."""
    times = recording.contacts.times
    during = (times >= point.start) & (times <= point.end)
    return recording.contacts.kinds[during].tolist(), recording.contacts.states[during]


def shots(level):
    """Return speeds of strokes that landed, and whether a good stroke answered them."""
    speeds, answered = [], []
    for recording, point in points_of(level):
        kinds, states = contacts_of(recording, point)
        struck = states[[kind == "racket" for kind in kinds]][:, 3:6]
        landed = len(struck) - (point.ended_by in ("net", "out"))
        speeds += np.linalg.norm(struck[1:landed], axis=1).tolist()
        answered += [number + 1 < landed for number in range(1, landed)]
    return np.array(speeds), np.array(answered)


def test_a_point_is_the_strokes_of_two_players_in_turn_and_decides_its_winner():
    other = {"near": "far", "far": "near"}
    for recording, point in points_of():
        kinds, states = contacts_of(recording, point)
        struck = [row for row, kind in enumerate(kinds) if kind == "racket"]
        directions = np.sign(states[struck, 4])
        assert kinds[:2] == ["launch", "racket"]
        assert len(directions) == point.strokes
        assert directions[0] == (1 if point.server == "near" else -1)
        assert (directions[1:] == -directions[:-1]).all()
        for number, (row, following) in enumerate(pairwise(struck)):
            table = [k for k in range(row + 1, following) if kinds[k] == "table"]
            assert len(table) == (2 if number == 0 else 1)
            assert np.sign(states[table[-1], 1]) == np.sign(states[row, 4])
        last = point.server if point.strokes % 2 else other[point.server]
        lost = point.ended_by in ("net", "out")
        assert point.winner == (other[last] if lost else last)


def test_a_toss_rises_16_cm_and_is_struck_behind_the_end_line_as_it_falls():
    for recording, point in points_of():
        times, states = recording.contacts.times, recording.contacts.states
        toss = np.flatnonzero(times == point.start)[0]
        seen = (recording.times >= times[toss]) & (recording.times < times[toss + 1])
        heights, struck = recording.positions[seen, 2], states[toss + 1]
        assert heights.max() - states[toss, 2] >= 0.16
        assert heights[-1] < heights.max()
        assert abs(struck[1]) > 1.37
        assert states[toss, 2] > 0


def test_all_ways_to_end_a_point_occur_and_none_but_those():
    endings = Counter(point.ended_by for _, point in points_of())

    assert set(endings) == {"net", "out", "double_bounce", "missed"}
    assert endings["missed"] + endings["double_bounce"] > 0.02 * endings.total()
    assert max(endings.values()) < 0.75 * endings.total()


def test_players_of_a_higher_level_strike_faster_and_with_more_spin():
    speeds, spins = [], []
    for level in LEVELS:
        states = [recording.contacts.states for recording in of_group(level)]
        kinds = np.concatenate([recording.contacts.kinds for recording in of_group(level)])
        struck = np.concatenate(states)[kinds == "racket"]
        speeds.append(np.median(np.linalg.norm(struck[:, 3:6], axis=1)))
        spins.append(np.median(np.linalg.norm(struck[:, 6:], axis=1)))

    assert (np.diff(speeds) > 0).all()
    assert (np.diff(spins) > 0).all()


def test_professionals_answer_shots_of_equal_pace_more_often():
    answers = {}
    for level in ("amateur", "pro"):
        speeds, answered = shots(level)
        answers[level] = answered[(speeds > 5) & (speeds < 8)].mean()

    assert answers["pro"] > answers["amateur"] + 0.03


@pytest.mark.parametrize("levels", [("amateur", "club"), ("semi_pro", "pro")])
def test_a_harder_shot_is_answered_less_often(levels):
    speeds, answered = (np.concatenate(parts) for parts in zip(*map(shots, levels), strict=True))
    hard = speeds > np.quantile(speeds, 0.85)

    assert answered[hard].mean() < answered[~hard].mean() - 0.05
