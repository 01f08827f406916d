"""The arena: repeatable, marked as synthetic, and its sealed truth explains what was measured."""

import numpy as np
import pytest

from rallygap.models.arena.recording import TrueContacts
from rallygap.models.arena.truth import Truth, draw_truth
from rallygap.models.arena.truth_path import true_states
from rallygap.models.ball.state import POSITION
from rallygap.pipeline.io.schemas import POSITION_COLUMNS, STATE_COLUMNS
from rallygap.pipeline.params import IngestSettings
from rallygap.pipeline.runtime.parallel import CLUSTER
from rallygap.pipeline.sources.gather import TABLES, gather
from tests.cluster import cluster
from tests.pipeline.sources.made_up import ARENA, read_again

LEVELS = {"amateur", "club", "semi_pro", "pro"}
GAMES = ARENA.model_copy(update={"game_episodes": 8})


def groups(ids):
    return set(ids.str.split("/").str[1])


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


def test_shots_of_the_cannon_begin_with_a_launch_and_games_have_an_umpire(session):
    ids = session.recordings["recording_id"].drop_duplicates()
    launched = ids.map(session.manifest.starts_with_launch)
    assert launched.sum() == ARENA.cannon_shots
    assert groups(ids[launched]) == {"cannon"}
    assert groups(ids[~launched]) == groups(session.points["recording_id"]) <= LEVELS


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


def test_the_truth_of_the_seed_and_the_true_contacts_explain_what_was_measured(session):
    truth = Truth.from_dict(session.truth)
    assert truth == draw_truth(0)
    contacts = dict(list(session.true_contacts.groupby("recording_id")))
    for recording_id, samples in session.recordings.groupby("recording_id"):
        true = contacts.pop(recording_id)
        states = true[STATE_COLUMNS].to_numpy()
        known = TrueContacts(true["t"].to_numpy(), true["kind"].to_numpy(dtype=str), states)
        path = true_states(truth, known, samples["t"].to_numpy())[:, POSITION]
        error = np.abs(samples[POSITION_COLUMNS].to_numpy() - path)
        assert np.median(error) < ARENA.position_noise
        assert np.quantile(error, 0.9) < 3 * ARENA.position_noise
    assert contacts == {}
