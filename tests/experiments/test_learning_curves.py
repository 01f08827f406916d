"""Learning curves: subsets, what is learned from them, and the curves of their errors."""

import numpy as np
import pandas as pd
import pytest

import experiments.stages.learning_curves as run
from experiments.learning_curves import Errors, Learner, curve_rows, subsets
from rallygap.models.ball.simulators import shipped
from rallygap.pipeline.runtime.stage_run import StageRun
from tests.models.predictors.small_training import BRIEF, TINY
from tests.pipeline.killed_runs import kill_at
from tests.pipeline.measured_shots import params, shot_tables, write_inputs

SPLITS = [*["train"] * 4, *["validation"] * 2]
CHANGES = {"sources": ["arena"], "networks": {"tiny": TINY}, "training": BRIEF}
PARAMS = params(train_predictor=params().train_predictor.model_copy(update=CHANGES))
TESTED = np.repeat(np.arange(30), 4)


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    root = tmp_path_factory.mktemp("repository")
    shots = [shot_tables("arena/club", k, split=split) for k, split in enumerate(SPLITS)]
    write_inputs(root, shots=shots)
    return root


def test_a_killed_run_resumes_and_publishes_curves(root, monkeypatch):
    amended = []

    def amend(self, subset, name):
        amended.append(subset.name)
        return shipped(name)

    monkeypatch.setenv("LOKY_MAX_CPU_COUNT", "1")
    monkeypatch.setattr(run, "SIZES", (2,))
    monkeypatch.setattr(run, "DRAWS", 2)
    monkeypatch.setattr(run, "NETWORKS", ("tiny",))
    monkeypatch.setattr(Learner, "amended", amend)
    stage = StageRun("learning_curves", root, PARAMS)
    kill_at(run, "_trained", run.learning_curves, stage)
    run.learning_curves(stage)
    assert sorted(amended) == ["2-0", "2-1", "4-0", "4-1"]
    rows = pd.read_csv(stage.report("errors.csv"))
    assert set(rows["predictor"]) == {"amended_imperfect_c", "tiny", "oracle"}
    assert set(rows["recordings"]) == {2, 4}
    assert set(rows["draws"]) == {2}


def test_larger_subsets_of_a_draw_contain_the_smaller_ones():
    names = [f"r{k}" for k in range(50)]
    found = list(subsets(names, (5, 20, 100), draws=2, seed=1))
    assert [one.name for one in found] == ["5-0", "20-0", "50-0", "5-1", "20-1", "50-1"]
    assert found[0].recordings < found[1].recordings < found[2].recordings == frozenset(names)
    assert found[0].recordings != found[3].recordings
    assert found == list(subsets(reversed(names), (5, 20, 100), draws=2, seed=1))


def test_a_network_sees_some_recordings_as_often_as_it_would_see_all(root, tmp_path):
    learner = Learner(root / "artifacts", "arena", PARAMS)
    few, whole, other, _ = subsets(learner.recordings, (2,), draws=2, seed=1)
    jobs = [learner.training(one, "tiny", tmp_path / one.name) for one in (few, whole, other)]
    assert [one.data.train.episodes for one in jobs] == [2, 4, 2]
    drawn = [one.data.train.episodes * one.data.settings.windows_per_episode for one in jobs]
    assert drawn[0] == pytest.approx(drawn[1], rel=0.3)
    assert jobs[0].data.validation.episodes == jobs[1].data.validation.episodes
    weights = [next(iter(jobs[k].network.parameters())) for k in (0, 2)]
    assert not weights[0].equal(weights[1])  # draws differ
    assert learner.amended(few, "imperfect_c") == shipped("imperfect_c")  # too few shots


def errors(predictor, recordings, size, spread=0.0, seed=0, draws=3):
    """Errors in m at two horizons, of which the second is twice the first."""
    random = np.random.default_rng(seed)
    of_windows = size * (1 + spread * random.standard_normal((draws, len(TESTED), 1)))
    return Errors(predictor, recordings, of_windows * [1.0, 2.0])


def test_errors_are_means_over_draws_in_mm_and_in_those_of_the_oracle():
    oracle, hybrid = errors("oracle", 10, 0.02), errors("hybrid", 10, 0.03)
    hybrid.by_draw[:, 0, 1] = np.nan  # a window without a measurement
    rows = curve_rows([oracle, hybrid], TESTED, [100, 200])
    hybrid = rows.set_index("predictor").loc["hybrid"]
    assert hybrid["mean"].tolist() == pytest.approx([30.0, 60.0])
    assert hybrid["median"].tolist() == pytest.approx([30.0, 60.0])
    assert hybrid["of_oracle"].tolist() == pytest.approx([1.5, 1.5])
    assert hybrid["ci_low"].tolist() == pytest.approx(hybrid["ci_high"].tolist())
    assert hybrid["n"].tolist() == [120, 119]


def test_intervals_have_the_spread_of_windows_and_of_draws():
    same = errors("oracle", 10, 0.02, spread=0.3, draws=1)
    draws = Errors("hybrid", 10, same.by_draw * np.array([0.5, 1.0, 1.5])[:, None, None])
    rows = curve_rows([same, draws], TESTED, [100, 200]).set_index(["predictor", "horizon_ms"])
    width = (rows["ci_high"] - rows["ci_low"]).xs(100, level=1)
    assert width["oracle"] == pytest.approx(2 * 1.96 * 20 * 0.3 / np.sqrt(120), rel=0.3)
    # Three draws that differ by half; t has two degrees of freedom.
    assert width["hybrid"] == pytest.approx(2 * 4.30 * 20 * 0.5 / np.sqrt(3), rel=0.1)
