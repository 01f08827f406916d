"""Scenes on measured sets: MuJoCo flies what a verdict predicts, and every recording once."""

import json

import joblib
import numpy as np
import pytest

from experiments import resumed
from rallygap.models.ball.simulators import shipped
from rallygap.models.engines.engine import EffectsEngine
from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.refit import fit_nuisance
from rallygap.models.gap.settings import DEFAULTS
from rallygap.models.gap.verify.prediction_error import HeldOut
from rallygap.pipeline.gap.measured_shots import read_shots
from rallygap.pipeline.runtime.stage_run import StageRun
from tests.experiments.made_up import cause, found
from tests.pipeline.recorded import write_recordings

pytest.importorskip("mujoco")

import experiments.stages.real_scenes as stage
from experiments.measured_scenes import HORIZONS, FlownPredictions
from experiments.simulators import TABLE, PublishedModel, _scene

TRUTH = shipped("literature")
NOISE = Noise()
SPIN = 150.0  # rad/s
LITTLE_AIR = PublishedModel(
    "lab/scene",
    "scene.xml",
    "little drag and lift",
    _scene('density="1.2"', 'fluidcoef=".1 0 0 0 .5" solref="-1000000 -53"', TABLE),
)


@pytest.fixture(scope="module")
def held(tmp_path_factory):
    """Held-out shots with their fits."""
    folder = write_recordings(tmp_path_factory.mktemp("sets") / "csv", shots=12)
    shots = read_shots(folder, "csv").shots
    return HeldOut.of(fit_nuisance(shots, TRUTH, NOISE, DEFAULTS.fit), shots, NOISE, DEFAULTS)


@pytest.mark.parametrize(
    ("effect", "values"),
    [("drag", {"cd": 0.3}), ("position_scale", {"s": 0.02}), ("clock_rate", {"d": 0.01}),
     ("speed_dependent_latency", {"tau": 5e-4})],
)  # fmt: skip
def test_errors_are_those_of_verdicts_where_the_engine_is_a_list(held, effect, values):
    simulator = TRUTH.amended(effect, **values)
    engine = EffectsEngine("list", simulator)
    flown = FlownPredictions(engine, 5e-4, simulator, NOISE, SPIN)
    places = [DEFAULTS.verify.horizons.index(one) for one in HORIZONS]
    known = np.sqrt(held.squares(simulator, SPIN, held.shots)[:, places])
    assert np.isfinite(known).any()
    assert flown.distances(held.shots, held.usable) == pytest.approx(known, abs=5e-4, nan_ok=True)


def test_errors_before_and_after_amending_are_written(tmp_path, monkeypatch):
    """A diagnosis is replaced by the right answer; MuJoCo flies it."""
    write_recordings(tmp_path / "sets" / "csv", shots=9)
    monkeypatch.setenv("RALLYGAP_DATA", str(tmp_path / "sets"))
    names = {"drag.cd": 0.54, "magnus.cm": 0.069, "table_bounce.friction": 0.25}
    right = found(*(cause(name, value, nominal=1.0) for name, value in names.items()))
    monkeypatch.setattr(resumed, "diagnose", lambda shots, simulator: right)
    monkeypatch.setattr(stage, "PARTS", 2)
    monkeypatch.setattr(stage, "SETS", ("csv",))
    monkeypatch.setattr(stage, "SCENES", ("lab/scene",))
    monkeypatch.setattr(stage, "PUBLISHED", (LITTLE_AIR,))
    with joblib.parallel_config(backend="sequential"):
        stage.real_scenes(StageRun("real_scenes", tmp_path, None))
    content = json.loads((tmp_path / "reports" / "real_scenes" / "errors.json").read_text())
    one = content["csv"]["lab/scene"]
    assert 7 <= one["shots"][0] <= 9
    assert one["leading"] == 2 * [list(names)]
    before, after, floor = (np.array(one[f"{key}_mm"]) for key in ("before", "after", "floor"))
    assert (after < 0.7 * before).all()
    assert after[0] == pytest.approx(floor[0], rel=0.3)  # later, the bounces differ
    assert one["fall_mm"][0] > 0.0
