"""Scenes with something wrong: amended balls fly in their engines as the hidden physics says."""

import joblib
import numpy as np
import pytest

from rallygap.models.audit.launches import launches
from rallygap.pipeline.runtime.stage_run import StageRun

pytest.importorskip("mujoco")
pytest.importorskip("pybullet")

import experiments.stages.simulators as experiment
from experiments import simulators
from experiments.simulators import TRUTH, scenes

SCENES = {f"{one.engine}.{one.name}": one for one in scenes()}
TIMES = np.array([0.1, 0.3])


@pytest.mark.parametrize("name", ["mujoco.euler", "pybullet.vacuum"])
def test_the_true_physics_as_code_is_exact_in_the_engine(name):
    states = launches(TRUTH, 6, 2, np.random.default_rng(0)).states
    flown = SCENES[name].fly_amended(TRUTH, states, TIMES)
    away = np.linalg.norm((flown - TRUTH.fly(states, TIMES).states)[..., :3], axis=-1)
    assert away.max() < 1e-4


def test_spins_are_larger_and_bend_paths_more(monkeypatch):
    monkeypatch.setattr(simulators, "POINTS", 60)
    monkeypatch.setattr(simulators, "LEVELS", ("club",))
    usual, larger = simulators.larger_spins()["club"]
    assert larger["spin_median"] == pytest.approx(1.7 * usual["spin_median"], rel=0.15)
    assert larger["bend_mm"] > 1.2 * usual["bend_mm"]
    assert sum(larger["ended_by"].values()) == pytest.approx(1.0, abs=0.01)
    # All strokes but the serves.
    assert larger["strokes"] == pytest.approx(60 * (larger["strokes_a_point"] - 1), abs=0.5)


def test_published_models_are_audited():
    found = experiment.published_models()
    traps = {name: {one["identifier"] for one in row["traps"]} for name, row in found.items()}
    assert {"large_lift", "never_rolls"} <= traps["google-deepmind/competitive_robot_table_tennis"]
    assert {"no_drag", "no_lift"} <= traps["MyoHub/myosuite"]
    assert traps["xSpaceCoder/DeepLearningTennis3DUplift"] == {"inverse_lift"}
    assert traps["purdue-tracelab/TTRL-ICRA2026"] == {"no_lift"}


@pytest.mark.slow
def test_what_becomes_of_a_scene(tmp_path, monkeypatch):
    monkeypatch.setattr(experiment, "scenes", lambda: iter([SCENES["mujoco.vacuum"]]))
    monkeypatch.setattr(experiment, "SHOTS", 40)
    monkeypatch.setattr(experiment, "TESTED", 6)
    found = experiment.simulator_scenes(tmp_path)["mujoco"]["vacuum"]
    assert found["named_right"] and "drag.cd" in found["leading"]
    assert "no_drag" in found["traps"]
    assert found["after_mm"] < 0.1 * found["before_mm"]


def test_a_killed_run_publishes_nothing_and_goes_on(tmp_path, monkeypatch):
    made = []

    def result(scene):
        made.append(scene.name)
        if len(made) == 2:
            raise KeyboardInterrupt
        return {}

    for name in ("published_models", "larger_spins"):
        monkeypatch.setattr(experiment, name, dict)
    two = [SCENES["mujoco.vacuum"], SCENES["mujoco.drag"]]
    monkeypatch.setattr(experiment, "scenes", lambda: iter(two))
    monkeypatch.setattr(experiment, "scene_result", result)
    with joblib.parallel_config(backend="sequential"):
        with pytest.raises(KeyboardInterrupt):
            experiment.simulators(StageRun("simulators", tmp_path, None))
        assert not (tmp_path / "reports").exists()
        experiment.simulators(StageRun("simulators", tmp_path, None))
    assert made == ["vacuum", "drag", "drag"]
    names = {path.name for path in (tmp_path / "reports" / "simulators").iterdir()}
    assert names == {"larger_spins.json", "published.json", "scenes.json"}
