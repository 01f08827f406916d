"""The arena: repeatable, marked as synthetic, and its sealed truth explains what was measured."""

import numpy as np
import pytest

from rallygap.models.arena.recording import TrueContacts
from rallygap.models.arena.truth import Truth, draw_truth
from rallygap.models.arena.truth_path import true_states
from rallygap.models.ball.state import POSITION
from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS, VELOCITY_COLUMNS
from rallygap.pipeline.params import IngestSettings
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.parallel import CLUSTER
from rallygap.pipeline.sources.gather import TABLES, gather
from tests.cluster import cluster
from tests.pipeline.sources.made_up import ARENA, read_again

LEVELS = {"amateur", "club", "semi_pro", "pro"}
GAMES = ARENA.model_copy(update={"game_episodes": 8})


def group(table):
    return table["recording_id"].str.split("/").str[1]


def gathered(folder, processes):
    """Gather with so many processes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LOKY_MAX_CPU_COUNT", str(processes))
        return gather(IngestSettings(folder=None, sources=["arena"], arena=GAMES), 0, folder)


def bytes_of(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("one_process")


@pytest.fixture(scope="module")
def session(folder):
    return read_again(gathered(folder, 1), folder)


def test_shots_of_the_cannon_begin_with_a_launch_and_games_do_not(session):
    ids = session.recordings["recording_id"].drop_duplicates()
    launched = ids.map(session.manifest.starts_with_launch)
    assert launched.sum() == ARENA.cannon_shots
    assert ids[launched].str.startswith("arena/cannon/").all()
    assert set(ids[~launched].str.split("/").str[1]) <= LEVELS


def test_two_processes_write_the_same_bytes(tmp_path, session, folder):
    gathered(tmp_path, 2)
    assert set(bytes_of(tmp_path)) == {f"{name}.parquet" for name in TABLES}
    assert bytes_of(tmp_path) == bytes_of(folder)


@pytest.mark.slow
def test_a_cluster_writes_the_same_bytes(tmp_path, monkeypatch, session, folder):
    with cluster(tmp_path) as found:
        monkeypatch.setenv(CLUSTER, found.address)
        gathered(tmp_path / "tables", 1)
    assert bytes_of(tmp_path / "tables") == bytes_of(folder)


def test_a_cluster_that_is_not_there_is_an_error_and_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr("rallygap.pipeline.runtime.parallel.PATIENCE", 0.5)
    monkeypatch.setenv(CLUSTER, "carrier-pigeon://loft:1")
    with pytest.raises(InputError, match=f"{CLUSTER}: no scheduler answers"):
        gathered(tmp_path, 1)
    assert list(tmp_path.iterdir()) == []


def test_the_sealed_truth_is_the_seed_s_and_can_be_read_again(session):
    assert session.truth["seed"] == 0
    assert Truth.from_dict(session.truth) == draw_truth(0)


def test_the_truth_and_the_true_contacts_explain_what_was_measured(session):
    truth = Truth.from_dict(session.truth)
    contacts = dict(list(session.true_contacts.groupby("recording_id")))
    for recording_id, samples in session.recordings.groupby("recording_id"):
        true = contacts[recording_id]
        states = true[[*POSITION_COLUMNS, *VELOCITY_COLUMNS, *SPIN_COLUMNS]].to_numpy()
        known = TrueContacts(true["t"].to_numpy(), true["kind"].to_numpy(dtype=str), states)
        path = true_states(truth, known, samples["t"].to_numpy())[:, POSITION]
        error = np.abs(samples[POSITION_COLUMNS].to_numpy() - path)
        assert np.median(error) < ARENA.position_noise
        assert np.quantile(error, 0.9) < 3 * ARENA.position_noise


def test_the_umpire_counts_the_strokes_that_there_were(session):
    racket = session.true_contacts[session.true_contacts["kind"] == "racket"]
    assert len(session.points) > 0
    for point in session.points.itertuples():
        times = racket["t"][racket["recording_id"] == point.recording_id]
        assert times.between(point.start, point.end).sum() == point.strokes


def test_only_games_have_an_umpire(session):
    assert set(group(session.points)) <= LEVELS
    assert set(group(session.true_contacts)) == set(group(session.recordings))
