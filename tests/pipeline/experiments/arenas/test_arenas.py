"""Fresh arenas: what becomes of one, and how the verdicts on all are counted."""

import joblib
import pandas as pd
import pytest

import rallygap.stages.arenas as run
from rallygap.pipeline.experiments.arenas.scores import (
    coverage,
    found_by_size,
    gap_closed,
    made_up,
    ratios,
)
from rallygap.pipeline.experiments.arenas.world import arena_result
from rallygap.pipeline.gap import cases
from rallygap.pipeline.runtime.stage_run import StageRun
from tests.models.predictors.small_training import BRIEF, TINY, TINY_HYBRID, changed
from tests.pipeline.experiments.arenas.made_up import CAUSES, ERRORS
from tests.pipeline.experiments.known_answers.made_up import cause, found
from tests.pipeline.measured_shots import params

FEW = params().ingest.arena.model_copy(update={"game_episodes": 40, "cannon_shots": 40})
SHORT = {
    "networks": {"transformer": TINY, "hybrid": TINY_HYBRID},
    "training": changed(BRIEF, epochs=1),
}
SMALL = params(
    ingest=params().ingest.model_copy(update={"arena": FEW}),
    train_predictor=params().train_predictor.model_copy(update=SHORT),
)


@pytest.fixture
def quick(monkeypatch):
    """A verdict without the work."""
    verdict = found(cause("drag.cd", 0.47, nominal=0.4))
    monkeypatch.setattr(cases, "diagnose", lambda *given, **named: verdict)
    with joblib.parallel_config(backend="sequential"):
        yield


def test_an_arena_has_causes_and_errors(tmp_path, quick):
    result = arena_result(SMALL, 7, tmp_path)
    drag = result["causes"].query("effect == 'drag'").iloc[0]
    assert (drag["original"], drag["amended"]) == (0.4, 0.47)
    assert drag["truth"] not in (0.4, 0.47)
    errors = result["errors"].query("horizon_ms == 200").set_index("predictor")["mean"]
    assert errors["oracle"] < errors["amended"] < errors["imperfect_c"] < errors["transformer"]
    assert set(errors.index) == set(ERRORS["predictor"])
    assert not list(tmp_path.iterdir())


def test_arenas_differ(tmp_path, quick):
    one, other = (arena_result(SMALL, seed, tmp_path)["causes"] for seed in (7, 8))
    assert one["truth"].tolist() != other["truth"].tolist()


def test_a_worker_that_outlives_its_run_takes_nothing_from_the_next(tmp_path, quick, monkeypatch):
    verdict, started, other = cases.diagnose(), [], {}

    def meanwhile(*given, **named):
        if not started:
            started.append(True)
            other.update(arena_result(SMALL, 7, tmp_path))
        return verdict

    monkeypatch.setattr(cases, "diagnose", meanwhile)
    for name, table in arena_result(SMALL, 7, tmp_path).items():
        pd.testing.assert_frame_equal(table, other[name])


def test_a_killed_run_goes_on_with_the_arenas_that_are_missing(tmp_path, monkeypatch):
    made = []

    def result(settings, seed, scratch):
        made.append(seed)
        if seed == 3 and len(made) == 2:
            raise KeyboardInterrupt
        return {"causes": CAUSES, "errors": ERRORS.drop(columns="seed")}

    monkeypatch.setattr(run, "arena_result", result)
    monkeypatch.setattr(run, "SEEDS", [2, 3])
    with joblib.parallel_config(backend="sequential"):
        with pytest.raises(KeyboardInterrupt):
            run.arenas(StageRun("arenas", tmp_path, SMALL))
        run.arenas(StageRun("arenas", tmp_path, SMALL))
    assert made == [2, 3, 3]
    written = pd.read_csv(tmp_path / "reports" / "arenas" / "errors.csv")
    assert written["seed"].tolist() == [2] * 6 + [3] * 6


def test_causes_are_counted_by_their_size():
    counts = {name: (one.count, one.of) for name, one in found_by_size(CAUSES)}
    expected = {"below 1": (0, 1), "1 to 2": (0, 0), "2 to 4": (0, 0), "above 4": (2, 2)}
    assert counts == {**expected, "net": (1, 1)}


def test_what_is_made_up_and_covered_is_counted_over_named_causes():
    assert (made_up(CAUSES).count, made_up(CAUSES).of) == (1, 4)
    assert (coverage(CAUSES).count, coverage(CAUSES).of) == (2, 4)


def test_errors_are_compared_with_those_of_the_oracle():
    assert ratios(ERRORS, "amended", 300).tolist() == [1.2]
    assert gap_closed(ERRORS, 300).tolist() == [pytest.approx(56 / 60)]
