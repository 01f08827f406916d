"""Sessions: the same from the same seed, and as large as asked for."""

from itertools import islice

import pytest

from rallygap.models.arena.session import recordings, run_sequentially
from tests.models.arena.sessions import LEVELS, TRUTH, games, session, settings


def flattened(recording):
    contacts = recording.contacts
    arrays = (recording.times, recording.positions, recording.spins)
    arrays += (contacts.times, contacts.kinds, contacts.states)
    return recording.name, [array.tobytes() for array in arrays], recording.points


@pytest.fixture
def _small_batches(monkeypatch):
    monkeypatch.setattr("rallygap.models.arena.session.CANNON_BATCH", 10)
    monkeypatch.setattr("rallygap.models.arena.session.MATCH_BATCH", 2)


@pytest.mark.usefixtures("_small_batches")
def test_a_longer_session_begins_with_a_shorter_one_and_another_seed_gives_another():
    noise = {"position_noise": 0.003, "spin_noise": 0.05, "dropouts": 0.02, "outliers": 0.01}

    def played(*counts, seed=0):
        return list(map(flattened, recordings(settings(*counts, **noise), TRUTH, seed)))

    whole, cannon, games = played(200, 15), played(0, 3), played(10, 0)
    assert cannon == whole[:3]
    assert games == whole[15 : 15 + len(games)]
    assert len(whole) - 15 > len(games)
    other = played(10, 3, seed=1)
    assert other[0] != whole[0] and other[-1] != games[-1]


@pytest.mark.parametrize(
    ("batches", "wanted", "recordings_taken", "rounds"),
    [(1, {"cannon_shots": 21}, 21, [1, 1, 1]), (8, {"game_episodes": 10**6}, 9, [4, 8])],
)
@pytest.mark.usefixtures("_small_batches")
def test_no_more_than_a_round_is_shared_out_at_once(
    monkeypatch, batches, wanted, recordings_taken, rounds
):
    """A longer session would have to wait in memory; the first round of games is a guess."""
    monkeypatch.setattr("rallygap.models.arena.session.ROUND", batches)
    shared = []

    def share(tasks):
        shared.append(len(tasks))
        return run_sequentially(tasks)

    found = islice(recordings(settings(**wanted), TRUTH, 0, share), recordings_taken)
    assert len({recording.name for recording in found}) == recordings_taken
    assert shared == rounds


def test_it_has_as_many_strokes_and_shots_as_asked_for_and_all_levels_have_their_share():
    strokes = [sum(point.strokes for point in game.points) for game in games()]
    names = [recording.name for recording in session()]
    counts = [sum(name.startswith(f"{level}/") for name in names) for level in LEVELS]

    assert len(session()) - len(games()) == 40
    assert sum(strokes) >= 1500 > sum(strokes[: -len(LEVELS)])
    assert len(set(names)) == len(names)
    assert max(counts) == min(counts) > 5
