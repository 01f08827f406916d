"""The evaluation on measured balls whose physics is known."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from models.ball.simulators import shipped
from pipeline.artifacts import read_table, write_json, write_table
from pipeline.contracts import CONTACTS, EPISODES, SAMPLES, checked
from pipeline.errors import InputError
from pipeline.figures.shots import read_shots
from pipeline.params import PhysicsPredictorSettings, load_params
from pipeline.run import StageRun
from stages.evaluate_predictor import evaluate_predictor

TIMES = 0.005 * np.arange(101)
TRUTH = shipped("literature")
PREDICTORS = {
    "physics_true": PhysicsPredictorSettings(kind="physics", simulator="literature"),
    "physics_c": PhysicsPredictorSettings(kind="physics", simulator="imperfect_c"),
}


def params():
    repository = load_params(Path(__file__).parents[2] / "params.yaml")
    changes = {"predictors": PREDICTORS, "bootstrap_resamples": 50}
    evaluation = repository.evaluate_predictor.model_copy(update=changes)
    return repository.model_copy(update={"evaluate_predictor": evaluation})


def episode_tables(source, number, labelled, unbroken=True):
    """One clean shot from a cannon, as the segment stage would leave it."""
    ball = [0.1 * number, 1.3, 0.3, 0.2, -8.0, 0.5, -150.0 + 20 * number, 10.0, 5.0]
    flight = TRUTH.fly(ball, TIMES)
    states, bounce = flight.states[0], flight.contacts.time[0, 0]
    recording, name = f"{source}/{number}", f"{source}/{number}/00"
    spins = states[:, 6:] if labelled else np.full((len(TIMES), 3), np.nan)
    frame = pd.DataFrame(
        np.hstack([states[:, :6], spins]),
        columns=["px", "py", "pz", "vx", "vy", "vz", "wx", "wy", "wz"],
    )
    frame.insert(0, "t", TIMES)
    frame.insert(0, "arc", (bounce < TIMES).astype(int))
    frame.insert(0, "episode_id", name)
    frame.insert(0, "recording_id", recording)
    frame["outlier"] = False
    contact = {
        "recording_id": recording,
        "episode_id": name,
        "kind": "table",
        "t": bounce,
        "px": 0.0,
        "py": 0.0,
        "pz": 0.02,
        "speed_change": 4.0,
    }
    episode = {
        "episode_id": name,
        "recording_id": recording,
        "source": source,
        "start": 0.0,
        "end": TIMES[-1],
        "starts_with": "launch",
        "ends_with": "recording",
        "samples": len(TIMES),
        "outliers": 0,
        "bounces": 1,
        "residual": 0.003,
        "unbroken": unbroken,
    }
    return frame, contact, episode


def write_inputs(root, *, broken_too=False):
    parts = [episode_tables("labelled", k, labelled=True) for k in range(3)]
    parts += [episode_tables("plain", k, labelled=False) for k in range(3)]
    if broken_too:
        broken = episode_tables("plain", 3, labelled=False, unbroken=False)
        broken[0]["px"] += 3.0
        parts.append(broken)
    samples, contacts, episodes = zip(*parts, strict=True)
    folder = root / "artifacts" / "segment"
    write_table(folder / "samples.parquet", checked(pd.concat(samples, ignore_index=True), SAMPLES))
    write_table(folder / "contacts.parquet", checked(pd.DataFrame(contacts), CONTACTS))
    write_table(folder / "episodes.parquet", checked(pd.DataFrame(episodes), EPISODES))
    common = {
        "kind": "cannon",
        "licence": "made for this test",
        "note": "made for this test",
        "rate_hz": 200.0,
        "recordings": 3,
        "launches": 0,
        "rows_read": 303,
        "rows_kept": 303,
        "rows_refused": {},
        "labels_refused": {},
        "files": [],
    }
    sources = {
        name: {"name": name, "spin": spin, **common}
        for name, spin in (("labelled", "per_recording"), ("plain", "none"))
    }
    write_json(root / "artifacts" / "ingest" / "manifest.json", {"sources": sources})


def evaluated(root, **inputs):
    write_inputs(root, **inputs)
    run = StageRun("evaluate_predictor", root, params())
    evaluate_predictor(run)
    return run, json.loads(run.report("metrics.json").read_text())


def test_metrics_name_set_predictor_quantity_and_horizon(tmp_path):
    _, metrics = evaluated(tmp_path)
    assert set(metrics) == {"labelled", "plain"}
    leaf = metrics["labelled"]["physics_true"]["position"]["300"]
    assert set(leaf) == {"mean", "std", "n"}
    horizons = list(metrics["plain"]["physics_c"]["velocity"])
    assert horizons == [str(ms) for ms in range(100, 301, 5)]


def test_the_true_simulator_forecasts_best_where_the_spin_is_labelled(tmp_path):
    _, metrics = evaluated(tmp_path)
    true, wrong = (
        metrics["labelled"][name]["position"]["200"] for name in ("physics_true", "physics_c")
    )
    assert true["mean"] < wrong["mean"]
    assert true["n"] == wrong["n"] > 0


def test_unlabelled_spin_is_not_evaluated_and_a_label_ends_at_the_bounce(tmp_path):
    _, metrics = evaluated(tmp_path)
    assert "spin" not in metrics["plain"]["physics_true"]
    labelled = metrics["labelled"]["physics_true"]
    assert labelled["spin"]["100"]["mean"] < 1.0  # a stale label would be off by the bounce's spin
    assert labelled["spin"]["100"]["n"] < labelled["position"]["100"]["n"]


def test_broken_episodes_are_left_out(tmp_path):
    _, whole = evaluated(tmp_path / "a")
    _, with_broken = evaluated(tmp_path / "b", broken_too=True)
    assert with_broken == whole


def test_episodes_without_a_window_are_one_error_and_no_metrics(tmp_path):
    write_inputs(tmp_path)
    path = tmp_path / "artifacts" / "segment" / "episodes.parquet"
    write_table(path, read_table(path).assign(unbroken=False))
    run = StageRun("evaluate_predictor", tmp_path, params())
    with pytest.raises(InputError, match="no unbroken episode has a window"):
        evaluate_predictor(run)
    assert not run.report("metrics.json").exists()


def test_the_same_inputs_give_the_same_bytes(tmp_path):
    for name in ("a", "b"):
        evaluated(tmp_path / name)
    files = [path.relative_to(tmp_path / "a") for path in (tmp_path / "a").rglob("*.*")]
    assert len(files) > 8
    for path in files:
        if path.suffix in {".json", ".csv", ".png"}:
            assert (tmp_path / "a" / path).read_bytes() == (tmp_path / "b" / path).read_bytes()


def test_shots_take_turns_between_the_sets(tmp_path):
    run, _ = evaluated(tmp_path)
    shots = read_shots(run.artifact("shots.json"))
    assert [shot.source for shot in shots] == ["labelled", "plain"] * 3
    assert set(shots[0].forecasts) == {"physics_true", "physics_c"}


def test_a_bounce_makes_forecasting_harder_for_the_wrong_table(tmp_path):
    run, _ = evaluated(tmp_path)
    rows = pd.read_csv(run.report("forecast_error.csv"))
    chosen = rows[
        (rows.predictor == "physics_c") & (rows.quantity == "velocity") & (rows.horizon_ms == 300)
    ]
    error = chosen[chosen.set == "labelled"].set_index("bounce")["mean"]
    assert error["with"] > 0
    assert pytest.approx(error["all"]) == error["with"]
