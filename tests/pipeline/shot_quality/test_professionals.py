"""Measured shots of professionals, compared with the true ones."""

import numpy as np
import pandas as pd
import pytest

from rallygap.models.shot_quality.shots import FEATURES, landings
from rallygap.pipeline.io.artifacts import write_table
from rallygap.pipeline.io.schemas import POINTS, empty
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.shot_quality.professionals import read_professionals
from tests.pipeline.professional_games import TRUTH, played_games, write_games

MATCHES = 3


@pytest.fixture(scope="module")
def recordings():
    return played_games(MATCHES)


@pytest.fixture(scope="module")
def root(recordings, tmp_path_factory):
    folder = tmp_path_factory.mktemp("games")
    write_games(folder, recordings)
    return folder


@pytest.fixture(scope="module")
def shots(root):
    return read_professionals(root / "artifacts")


def true_returns(match, recording):
    """Landing states and outcomes of all strokes that came down on the other half first."""
    times, states = recording.contacts.times, recording.contacts.states
    direction, is_stroke = np.sign(states[:, 4]), recording.contacts.kinds == "racket"
    lands = (recording.contacts.kinds[1:] == "table") & (direction[:-1] * states[1:, 1] >= 0)
    for number in np.flatnonzero(is_stroke[:-1] & lands):
        (point,) = [one for one in recording.points if one.start <= times[number] <= one.end]
        landed = landings(TRUTH.simulator, states[number : number + 1])[0]
        landed *= np.array([direction[number], direction[number], 1.0] * 3)
        won = point.winner == ("near" if direction[number] > 0 else "far")
        own = is_stroke & (direction == direction[number]) & (times <= point.end)
        yield match, *landed, won, won and number == np.flatnonzero(own)[-1]


@pytest.fixture(scope="module")
def matched(shots, recordings):
    """Each found shot beside the true one that landed nearest to it in its match."""
    games = enumerate(recordings)
    true = pd.DataFrame([row for match, one in games for row in true_returns(match, one)])
    rows = []
    for features, match in zip(shots.features, shots.matches, strict=True):
        own = true[true[0] == match]
        apart = np.hypot(own[1] - features[0], own[2] - features[1])
        apart += np.abs(own[5] - features[3]) / 50
        rows.append(own.loc[apart.idxmin()])
    return len(true), pd.DataFrame(rows).reset_index(drop=True)


def test_nearly_all_good_returns_are_found_and_none_twice(shots, matched):
    count, true = matched
    assert len(shots) >= 0.9 * count
    assert not true.duplicated().any()
    assert set(shots.matches) == set(range(MATCHES))


def test_landings_are_measured_well(shots, matched):
    true = matched[1].drop(columns=[0, 3]).to_numpy(dtype=float)[:, :8]
    error = np.abs(shots.features[:, :8] - true)
    assert np.median(error[:, :2], axis=0).max() < 0.015  # m
    assert np.median(error[:, 2:5], axis=0).max() < 0.35  # m/s
    assert np.median(error[:, 5:], axis=0).max() < 10  # rad/s
    clearance = shots.features[:, FEATURES.index("clearance")]
    assert -0.02 < clearance.min() < np.median(clearance) < 0.4


def test_the_winner_is_the_umpires_decision(shots, matched):
    assert (shots.point == matched[1][10].to_numpy(dtype=bool)).all()
    assert (shots.wins == matched[1][11].to_numpy(dtype=bool)).all()
    assert shots.point[shots.wins].all() and shots.wins.any() and not shots.wins.all()


def test_without_games_of_professionals_one_error_says_what_to_do(root, tmp_path, shots):
    (tmp_path / "artifacts" / "ingest").mkdir(parents=True)
    (tmp_path / "artifacts" / "segment").symlink_to(root / "artifacts" / "segment")
    write_table(tmp_path / "artifacts" / "ingest" / "points.parquet", empty(POINTS))
    with pytest.raises(InputError, match="no return of a professional; ingest more games"):
        read_professionals(tmp_path / "artifacts")
