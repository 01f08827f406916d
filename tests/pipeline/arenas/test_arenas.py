"""Fresh arenas: what becomes of one, and how the verdicts on all are counted."""

import json

import joblib
import pandas as pd
import pytest

from pipeline.arenas import run
from pipeline.arenas.scores import coverage, found_by_size, gap_closed, made_up, ratios
from pipeline.arenas.world import arena_result
from pipeline.gap import cases
from tests.pipeline.arenas.made_up import CAUSES, ERRORS
from tests.pipeline.known_answers.made_up import cause, found
from tests.pipeline.measured_shots import params

SMALL = params()
SMALL = SMALL.model_copy(
    update={
        "ingest": SMALL.ingest.model_copy(
            update={
                "arena": SMALL.ingest.arena.model_copy(
                    update={"game_episodes": 40, "cannon_shots": 40}
                )
            }
        ),
    }
)


@pytest.fixture
def quick(monkeypatch):
    """A verdict without the work."""
    verdict = found(cause("drag.cd", 0.47, nominal=0.4))
    monkeypatch.setattr(cases, "diagnose", lambda *given, **named: verdict)
    with joblib.parallel_config(backend="sequential"):
        yield


def test_an_arena_has_causes_and_errors(tmp_path, quick):
    result = arena_result(SMALL, 7, tmp_path / "7")
    drag = result["causes"].query("effect == 'drag'").iloc[0]
    assert (drag["original"], drag["amended"]) == (0.4, 0.47)
    assert drag["truth"] not in (0.4, 0.47)
    errors = result["errors"].query("horizon_ms == 200").set_index("predictor")["mean"]
    assert errors["oracle"] < errors["amended"] < errors["imperfect_c"]
    assert not (tmp_path / "7").exists()


def test_arenas_differ(tmp_path, quick):
    one, other = (arena_result(SMALL, seed, tmp_path / str(seed))["causes"] for seed in (7, 8))
    assert one["truth"].tolist() != other["truth"].tolist()


def test_a_killed_run_goes_on_with_the_arenas_that_are_missing(tmp_path, monkeypatch):
    made = []

    def result(settings, seed, folder):
        made.append(seed)
        if seed == 3 and len(made) == 2:
            raise KeyboardInterrupt
        return {"causes": CAUSES, "errors": ERRORS.drop(columns="seed")}

    for name in run.DEPENDENCIES:
        (tmp_path / name).mkdir(parents=True)
    monkeypatch.setattr(run, "arena_result", result)
    monkeypatch.setattr(run, "load_params", lambda path: SMALL)
    monkeypatch.setattr(run, "SEEDS", (2, 3))
    with joblib.parallel_config(backend="sequential"):
        with pytest.raises(KeyboardInterrupt):
            run.arenas(tmp_path)
        run.arenas(tmp_path)
    assert made == [2, 3, 3]
    written = pd.read_csv(tmp_path / run.REPORT / "errors.csv")
    assert written["seed"].tolist() == [2] * 4 + [3] * 4
    assert "commit" in json.loads((tmp_path / run.REPORT / "arenas.json").read_text())
    assert (tmp_path / run.REPORT / "arenas.png").exists()
    assert not (tmp_path / run.SCRATCH).exists()


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
