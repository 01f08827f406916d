"""The stage evaluate_predictor on shots whose physics is known."""

import json
import shutil

import numpy as np
import pytest

from rallygap.pipeline.evaluation.example_shots import read_shots
from rallygap.pipeline.io.artifacts import read_table, write_table
from rallygap.pipeline.io.metrics import place
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.stages.evaluate_predictor import evaluate_predictor
from tests.pipeline.amendments import write_amended
from tests.pipeline.measured_shots import (
    NOISE,
    params,
    shot_tables,
    write_inputs,
    write_trained,
)
from tests.stages.outputs import items, table, written


def evaluated(root, processes=1, **inputs):
    write_inputs(root, **inputs)
    run = StageRun("evaluate_predictor", root, params())
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LOKY_MAX_CPU_COUNT", str(processes))
        evaluate_predictor(run)
    return run, means(run)


def means(run):
    """Mean, deviation and count by set, predictor, quantity and horizon, over all windows."""
    found = {}
    for row in run.kept(run.stage, "errors").query("bounce == 'all'").to_dict("records"):
        label = row["set"] if row["against"] == "measured" else f"{row['set']}_{row['against']}"
        keys = (label, row["predictor"], row["quantity"], row["horizon_ms"])
        place(found, keys).update({name: row[name] for name in ("mean", "std", "n")})
    return found


def test_metrics_are_the_mean_position_errors_at_the_farthest_horizon(whole):
    run, found = whole
    metrics = json.loads(run.report("metrics.json").read_text())
    for name, errors in metrics.items():
        assert set(errors) < set(found[name])
        for predictor, mean in errors.items():
            last = found[name][predictor]["position"]["300"]["mean"]
            assert mean == pytest.approx(last, rel=1e-5)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """One run on all sets; not to be changed."""
    return evaluated(tmp_path_factory.mktemp("whole"))


def test_the_oracle_forecasts_on_the_arena_alone_and_spins_where_they_are_labelled(whole):
    _, metrics = whole
    trained = {"physics_true", "physics_c", "tiny"}
    assert set(metrics["labelled"]) == set(metrics["plain"]) == trained
    assert set(metrics["arena"]) == {*trained, "oracle"}
    assert metrics["arena"]["oracle"] == metrics["arena"]["physics_true"]  # the same simulator
    true, wrong = (
        metrics["labelled"][name]["position"]["200"] for name in ("physics_true", "physics_c")
    )
    assert true["mean"] < wrong["mean"]
    assert true["n"] == wrong["n"] > 0
    assert "spin" not in metrics["plain"]["physics_true"]
    labelled = metrics["labelled"]["physics_true"]
    assert labelled["spin"]["100"]["mean"] < 1.0  # a stale label would be off by the bounce's spin
    assert labelled["spin"]["100"]["n"] < labelled["position"]["100"]["n"]


def test_errors_against_the_truth_lack_the_measurement_noise(whole):
    _, metrics = whole
    measured, true = (metrics[name]["oracle"]["position"] for name in ("arena", "arena_truth"))
    assert [one["n"] for one in measured.values()] == [one["n"] for one in true.values()]
    squares = [
        np.mean([one["mean"] ** 2 + one["std"] ** 2 for one in errors.values()])
        for errors in (measured, true)
    ]
    # The noise of three coordinates, which no forecast can know, in mm.
    assert squares[0] - squares[1] == pytest.approx(3 * (1000 * NOISE) ** 2, rel=0.3)


def test_an_amended_simulator_is_evaluated_on_its_own_source_and_a_tuned_network_as_well(tmp_path):
    write_trained(tmp_path, "tiny_fine_tuned", sources=["plain"], starts_from="tiny")
    folder = tmp_path / "artifacts" / "close_gap"
    for source in ("plain", "elsewhere"):
        write_amended(folder, source, "imperfect_c", {"drag": {"cd": 0.54}})
    run, metrics = evaluated(tmp_path, sources=("plain",))
    own = {"tiny_fine_tuned", "amended_imperfect_c"}
    assert set(metrics["plain"]) == {"physics_true", "physics_c", "tiny", *own}
    errors = {name: found["velocity"]["300"]["mean"] for name, found in metrics["plain"].items()}
    assert errors["amended_imperfect_c"] < errors["physics_c"]
    rows = table(run, "forecast_error_difference").query("set == 'plain'")
    assert ("amended_imperfect_c", "physics_c") in set(zip(rows.predictor, rows.other, strict=True))
    rows = table(run, "predictors", "predictor")
    assert rows.loc["amended_imperfect_c", "trained on"].tolist() == ["elsewhere", "plain"]
    tuned = rows.loc["tiny_fine_tuned"]
    assert (tuned["starts from"], tuned["trained on"]) == ("tiny", "plain")
    assert tuned["parameters"] > 1000


def test_sets_are_calibrated_by_validation_windows(whole, tmp_path):
    """The shots of the test and those of the validation are alike, so coverage is as stated."""
    assert table(whole[0], "coverage").empty  # without validation windows
    shots = [shot_tables("arena/club", number, split="validation") for number in range(7)]
    shots += [shot_tables("arena/amateur", number) for number in range(7)]
    run, metrics = evaluated(tmp_path, sources=("arena",), shots=shots)
    rows = table(run, "coverage").set_index(["predictor", "level", "horizon_ms"]).sort_index()
    assert set(rows.index.levels[0]) == set(metrics["arena"])
    for level in (0.5, 0.9):
        found = rows.loc[("oracle", level)]
        assert found["coverage"].mean() == pytest.approx(level, abs=0.2)
        assert (found["ci_low"] <= found["coverage"]).all()
    assert (rows["size_mm"].loc[("oracle", 0.9)] > rows["size_mm"].loc[("oracle", 0.5)]).all()
    error = metrics["arena"]["oracle"]["position"]["300"]["mean"]
    assert 0.1 * error < rows["crps_mm"].loc[("oracle", 0.9, 300)] < error
    assert "figures/coverage_arena.png" in {item.file for item in items(run)}


def test_without_a_window_or_a_trained_predictor_there_is_one_error_and_no_metrics(tmp_path):
    write_inputs(tmp_path, sources=("plain",))
    run = StageRun("evaluate_predictor", tmp_path, params())
    path = tmp_path / "artifacts" / "segment" / "episodes.parquet"
    write_table(path, read_table(path).assign(unbroken=False))
    with pytest.raises(InputError, match="no unbroken test episode has a window"):
        evaluate_predictor(run)
    shutil.rmtree(tmp_path / "artifacts" / "train_predictor")
    with pytest.raises(InputError, match="dvc repro train_predictor"):
        evaluate_predictor(run)
    assert not run.report("metrics.json").exists()


def test_differences_are_paired_on_the_same_windows(whole):
    run, metrics = whole
    rows = table(run, "forecast_error_difference")
    arena = rows[rows.set == "arena"]
    pairs = set(zip(arena.predictor, arena.other, strict=True))
    assert pairs == {("tiny", name) for name in ("physics_true", "physics_c", "oracle")}
    assert (arena.lower_share == 0).all()  # it was not really trained
    row = rows.query("set == 'plain' and other == 'physics_c' and quantity == 'position'").iloc[0]
    mean = {name: metrics["plain"][name]["position"]["100"]["mean"] for name in ("tiny", row.other)}
    assert row["mean"] == pytest.approx(mean["tiny"] - mean[row.other], rel=1e-4)
    assert row.ci_low <= row["mean"] <= row.ci_high


def test_errors_by_group_of_recordings_and_by_net_contact(whole):
    run, metrics = whole
    rows = table(run, "forecast_error_by_group")
    assert set(rows[rows.set == "arena"].group) == {"cannon", "pro"}
    assert set(rows[rows.set != "arena"].group) == {"all"}
    oracle = rows.query("set == 'arena' and predictor == 'oracle'")
    mean = np.average(oracle["mean"], weights=oracle["n"])
    assert mean == pytest.approx(metrics["arena"]["oracle"]["position"]["300"]["mean"], rel=1e-4)
    rows = table(run, "forecast_error_by_net")
    assert set(rows["set"]) == {"arena"} and set(rows["net"]) == {"without"}
    mean = rows.set_index("predictor")["mean"]["oracle"]
    assert mean == pytest.approx(metrics["arena"]["oracle"]["position"]["300"]["mean"], rel=1e-4)


def test_episodes_that_are_broken_or_not_for_testing_are_left_out(tmp_path, whole):
    more = [shot_tables("plain", 3, unbroken=False), shot_tables("plain", 4, split="train")]
    for one in more:
        one[0]["px"] += 3.0
    _, metrics = evaluated(tmp_path, sources=("plain",), shots=more)
    assert metrics["plain"] == whole[1]["plain"]


def test_the_same_inputs_give_the_same_bytes_on_one_and_two_processes(tmp_path, whole):
    again, _ = evaluated(tmp_path, processes=2)
    assert written(again) == written(whole[0])


def test_example_shots_alternate_between_the_sets(whole):
    run, _ = whole
    shots = read_shots(run.artifact("shots.json"))
    assert [shot.source for shot in shots][:6] == ["arena", "labelled", "plain"] * 2
    assert set(shots[0].forecasts) - set(shots[1].forecasts) == {"oracle"}
