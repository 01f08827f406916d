"""The stage evaluate_predictor on shots whose physics is known."""

import shutil

import numpy as np
import pytest

from rallygap.pipeline.io.artifacts import read_json, read_table, write_table
from rallygap.pipeline.io.metrics import nested
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.stages.evaluate_predictor import evaluate_predictor
from tests.pipeline.amendments import write_amended
from tests.pipeline.measured_shots import NOISE, params, shot_tables, write_inputs, write_trained
from tests.stages.outputs import table, written


def evaluated(root, processes=1, **inputs):
    write_inputs(root, **inputs)
    run = StageRun("evaluate_predictor", root, params())
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LOKY_MAX_CPU_COUNT", str(processes))
        evaluate_predictor(run)
    rows = run.kept(run.stage, "errors").query("bounce == 'all'").drop(columns="bounce")
    rows["set"] += rows.pop("against").map({"measured": "", "truth": "_truth"})
    return run, nested(rows, ["set", "predictor", "quantity", "horizon_ms"])


def test_metrics_are_the_mean_position_errors_at_the_farthest_horizon(whole):
    run, found = whole
    metrics = read_json(run.report("metrics.json"))
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
    true, wrong = (metrics["labelled"][name] for name in ("physics_true", "physics_c"))
    assert true["position"]["200"]["mean"] < wrong["position"]["200"]["mean"]
    assert true["position"]["200"]["n"] == wrong["position"]["200"]["n"] > 0
    assert "spin" not in metrics["plain"]["physics_true"]
    assert true["spin"]["100"]["mean"] < 1.0  # a stale label would be off by the bounce's spin
    assert true["spin"]["100"]["n"] < true["position"]["100"]["n"]


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
    assert run.report("figures/coverage_arena.png").exists()


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


def test_differences_groups_and_net_contacts_are_of_the_same_windows(whole):
    run, metrics = whole
    rows = table(run, "forecast_error_difference").query("set == 'arena'")
    others = ("physics_true", "physics_c", "oracle")
    assert set(zip(rows.predictor, rows.other, strict=True)) == {("tiny", one) for one in others}
    mean = metrics["arena"]["oracle"]["position"]["300"]["mean"]
    rows = table(run, "forecast_error_by_group", "set").query("predictor == 'oracle'")
    assert rows.group.to_list() == ["cannon", "pro"]
    assert np.average(rows["mean"], weights=rows["n"]) == pytest.approx(mean, rel=1e-4)
    rows = table(run, "forecast_error_by_net", "set", "net").query("predictor == 'oracle'")
    assert rows["mean"].to_dict() == {("arena", "without"): pytest.approx(mean, rel=1e-4)}


def test_episodes_that_are_broken_or_not_for_testing_are_left_out(tmp_path, whole):
    more = [shot_tables("plain", 3, unbroken=False), shot_tables("plain", 4, split="train")]
    for one in more:
        one[0]["px"] += 3.0
    _, metrics = evaluated(tmp_path, sources=("plain",), shots=more)
    assert metrics["plain"] == whole[1]["plain"]


def test_the_same_inputs_give_the_same_bytes_on_one_and_two_processes(tmp_path, whole):
    again, _ = evaluated(tmp_path, processes=2)
    assert written(again) == written(whole[0])
