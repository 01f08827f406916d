"""Fresh arenas: what becomes of one, and how the verdicts on all are counted."""

import joblib
import pandas as pd
import pytest

import experiments.stages.arenas as run
from experiments.arena_scores import found_by_size, ratios, scored
from experiments.arenas import arena_result
from rallygap.models.arena.truth import draw_truth
from rallygap.pipeline.gap import cases
from rallygap.pipeline.runtime.stage_run import StageRun
from tests.experiments.made_up import cause, few_balls, found
from tests.models.predictors.small_training import BRIEF, TINY, TINY_HYBRID, changed

CAUSES = pd.DataFrame(
    [
        ("drag", "cd", 0.4, 0.49, 0.48, 0.50, 0.491, 0.01),  # named, nine times the limit
        ("wind", "x", None, 0.1, 0.08, 0.09, 0.1, 0.02),  # named, not covered
        ("wind", "y", None, None, None, None, 0.01, 0.02),  # hidden, below the limit
        ("wind", "z", None, 0.3, 0.1, 0.4, 0.0, 0.2),  # made up
        ("net", "friction", None, 0.5, 0.45, 0.55, 0.51, None),
        ("racket_bounce", "kp", 1.0, 1.0, None, None, 2.0, None),
        ("camera_distortion", "amplitude", None, 0.002, 0.001, 0.003, None, None),
    ],
    columns=["effect", "parameter", "original", "amended", "low", "high", "truth", "detectable"],
)
MEANS = {
    "imperfect_c": 80.0,
    "imperfect_c_with_net": 60.0,
    "transformer": 30.0,
    "hybrid": 22.0,
    "amended": 24.0,
    "oracle": 20.0,
}
ERRORS = pd.DataFrame({"predictor": MEANS.keys(), "horizon_ms": 300, "mean": MEANS.values()})
SMALL = few_balls({"transformer": TINY, "hybrid": TINY_HYBRID}, changed(BRIEF, epochs=1))


def test_an_arena_has_causes_and_errors_and_another_run_at_once_does_not_disturb_it(
    tmp_path, monkeypatch
):
    verdict, other = found(cause("drag.cd", 0.47, nominal=0.4)), []

    def meanwhile(*given, **named):
        if not other:
            other.append(None)
            other.append(arena_result(SMALL, 7, tmp_path))
        return verdict

    monkeypatch.setattr(cases, "diagnose", meanwhile)
    with joblib.parallel_config(backend="sequential"):
        result = arena_result(SMALL, 7, tmp_path)
    drag = result["causes"].query("effect == 'drag'").iloc[0]
    assert (drag["original"], drag["amended"]) == (0.4, 0.47)
    assert drag["truth"] == draw_truth(7).simulator.effects["drag"]["cd"]
    errors = result["errors"].query("horizon_ms == 200").set_index("predictor")["mean"]
    assert errors["oracle"] < errors["amended"] < errors["imperfect_c"] < errors["transformer"]
    assert set(errors.index) == set(MEANS)
    for name, table in result.items():
        pd.testing.assert_frame_equal(table, other[1][name])
    assert not list(tmp_path.iterdir())


def test_a_killed_run_goes_on_with_the_arenas_that_are_missing(tmp_path, monkeypatch):
    made = []

    def result(settings, seed, scratch):
        made.append(seed)
        if seed == 3 and len(made) == 2:
            raise KeyboardInterrupt
        return {"causes": CAUSES, "errors": ERRORS}

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
    counts = {name: (named, hidden) for name, named, hidden in found_by_size(CAUSES)}
    expected = {"below 1": (0, 1), "1 to 2": (0, 0), "2 to 4": (0, 0), "above 4": (2, 2)}
    assert counts == {**expected, "net": (1, 1)}
    named = scored(CAUSES).query("named")
    assert (len(named), named["covered"].sum(), (~named["hidden"]).sum()) == (4, 2, 1)
    assert ratios(ERRORS.assign(seed=5), "amended", 300).tolist() == [1.2]
