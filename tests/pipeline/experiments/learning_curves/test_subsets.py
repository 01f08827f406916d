"""Subsets grow within a draw, and what is learned from one needs nothing else."""

import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.pipeline.experiments.learning_curves.subsets import Learner, subsets
from tests.models.predictors.small_training import BRIEF, TINY
from tests.pipeline.measured_shots import params, shot_tables, write_inputs

SPLITS = [*["train"] * 6, *["validation"] * 2]
NAMES = [f"r{k}" for k in range(50)]


def test_larger_subsets_of_a_draw_contain_the_smaller_ones():
    found = list(subsets(NAMES, (5, 20, 100), draws=2, seed=1))
    assert [(one.size, one.draw) for one in found] == [
        (5, 0), (20, 0), (50, 0), (5, 1), (20, 1), (50, 1),
    ]  # fmt: skip
    assert found[0].recordings < found[1].recordings < found[2].recordings == frozenset(NAMES)
    assert found[0].recordings != found[3].recordings
    assert found == list(subsets(reversed(NAMES), (5, 20, 100), draws=2, seed=1))


@pytest.fixture(scope="module")
def learner(tmp_path_factory):
    root = tmp_path_factory.mktemp("repository")
    shots = [shot_tables("arena/club", k, split=split) for k, split in enumerate(SPLITS)]
    write_inputs(root, shots=shots)
    changes = {"sources": ["arena"], "networks": {"tiny": TINY}, "training": BRIEF}
    settings = params().train_predictor.model_copy(update=changes)
    return Learner(root / "artifacts", "arena", params(train_predictor=settings))


def test_a_network_sees_some_recordings_as_often_as_it_would_see_all(learner, tmp_path):
    few, *_, whole = subsets(learner.recordings, (2,), draws=1, seed=1)
    jobs = [learner.training(one, "tiny", tmp_path / one.name) for one in (few, whole)]
    assert [one.data.train.episodes for one in jobs] == [2, len(learner.recordings)]
    drawn = [one.data.train.episodes * one.data.settings.windows_per_episode for one in jobs]
    assert drawn[0] == pytest.approx(drawn[1], rel=0.3)
    assert jobs[0].data.validation.episodes == jobs[1].data.validation.episodes


def test_draws_differ_in_their_weights(learner, tmp_path):
    first, _, second, _ = subsets(learner.recordings, (2,), draws=2, seed=1)
    weights = [
        next(iter(learner.training(one, "tiny", tmp_path / one.name).network.parameters()))
        for one in (first, second)
    ]
    assert not weights[0].equal(weights[1])


def test_too_few_shots_amend_nothing(learner):
    few, _ = subsets(learner.recordings, (2,), draws=1, seed=1)
    assert learner.amended(few, "imperfect_c") == shipped("imperfect_c")
