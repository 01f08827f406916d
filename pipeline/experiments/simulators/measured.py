"""Published scenes of MuJoCo on measured sets (``make real-scenes``); writes ``real.json``.

Every recording is held out once. A scene is audited, diagnosed on the other parts of the set, and
its ball amended. Then MuJoCo flies predictions of the held-out part, by the scene as it is and by
the code that is given back. A killed run resumes.

Errors are measured as those of a verdict are (``models/gap/verify/prediction_error.py``): a shot is
fitted on its first samples alone, about the list of effects that stands for the engine, and the
sensor is that of the list. But the engine itself flies from there.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from numpy import int64
from numpy.typing import NDArray
from rallygap.pipeline.experiments.experiment import running
from scipy.interpolate import make_interp_spline

from rallygap.models.ball.sensor import delays, measured_positions, true_times
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, VELOCITY
from rallygap.models.ball.types import Floats
from rallygap.models.engines.engine import Engine
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.gap.fit.horizons import at_horizons, first_samples, last_observed_time
from rallygap.models.gap.fit.linearize import ballistic_nuisance
from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.refit import RefitResult, fit_nuisance, refit
from rallygap.models.gap.fit.shot_fit import fit_shots, refit_shots
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.name.label_readings import read_labels
from rallygap.models.gap.settings import DEFAULTS
from rallygap.models.gap.types import Bools
from rallygap.models.gap.verdict import Verdict
from rallygap.models.gap.verify.bootstrap import drawn_shots, interval
from rallygap.models.gap.verify.prediction_error import HeldOut
from rallygap.models.gap.verify.replicates import simulate_replicate
from rallygap.pipeline.engines.audited import audited
from rallygap.pipeline.engines.export.code import ball_effects
from rallygap.pipeline.engines.export.code_engine import CodeEngine
from rallygap.pipeline.experiments.simulators.published import PUBLISHED, PublishedModel
from rallygap.pipeline.gap.folds import fold_numbers
from rallygap.pipeline.gap.measured_shots import read_shots
from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.known_answers.answers import Diagnosis, fingerprint, verdicts
from rallygap.pipeline.runtime.console import refuse
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.parallel import parallel
from rallygap.pipeline.runtime.paths import repository_root

SETS = ("tt3d", "spindoe")
# Scenes whose balls bounce.
SCENES = ("google-deepmind/competitive_robot_table_tennis", "MyoHub/myosuite")
PARTS = 3
HORIZONS: Floats = np.array([0.1, 0.2, 0.3])  # s
REPORT = Path("reports") / "simulators" / "real.json"
MM, MS = 1e3, 1e3


@dataclass(frozen=True)
class FlownPredictions:
    """Predictions that an engine flies.

    Attributes:
        engine: that flies them.
        step: s, of the engine.
        simulator: the list of effects that stands for it, with its sensor.
        noise: of the sensor.
        spin: rad/s, the size of a component of a spin: the prior of one without a label.
    """

    engine: Engine
    step: float
    simulator: Simulator
    noise: Noise
    spin: float

    def distances(self, shots: Shots, usable: Bools) -> Floats:
        """Return (B, 3) m from measured balls to predicted ones, NaN where a shot has none.

        Each is the root mean square over the samples about a horizon, which counts from the last
        sample that a prediction observes.

        Args:
            shots: B of them, measured or simulated.
            usable: (B, N) samples that count.

        Raises:
            EngineError: the engine fails.
        """
        observed = last_observed_time(shots, DEFAULTS) - shots.times[:, :1]
        end = float(observed.max()) + HORIZONS[-1] + DEFAULTS.horizon_window
        since = np.minimum(shots.times - shots.times[:, :1], end)  # later samples do not count
        away = shots.positions - self._measured(self._launches(shots), since)
        squares = (away**2).sum(axis=2)
        return np.asarray(np.sqrt(at_horizons(shots, squares, usable, HORIZONS, DEFAULTS)))

    def _launches(self, shots: Shots) -> Floats:
        """Return the (B, 9) states that fit the first samples."""
        early, settings = first_samples(shots, DEFAULTS.observed_samples), DEFAULTS.fit
        start = ballistic_nuisance(fit_shots(early, self.simulator, settings).nuisance, 0)
        fit = refit_shots(early, self.simulator, start, self.noise, settings, spin=self.spin)
        return fit.nuisance

    def _measured(self, launched: Floats, times: Floats) -> Floats:
        """Return (B, N, 3) measured positions, m, at (B, N) times of the sensor."""
        moments = true_times(self.simulator, times)
        marks = self.step * np.arange(np.ceil(moments.max() / self.step) + 1)
        flown = self.engine.fly(launched, marks[1:])
        paths = np.concatenate([launched[:, None], flown], axis=1)
        speeds = np.linalg.norm(_between(marks, paths, moments)[..., VELOCITY], axis=-1)
        seen = _between(marks, paths, moments - delays(self.simulator, speeds))
        return measured_positions(self.simulator, seen[..., POSITION])


def _between(marks: Floats, paths: Floats, moments: Floats) -> Floats:
    """Return (B, N, 9) states at (B, N) moments; paths are linear between their (T,) marks."""
    pairs = zip(paths, moments, strict=True)
    return np.stack([make_interp_spline(marks, path, k=1)(when) for path, when in pairs])


@dataclass(frozen=True)
class MeasuredScene:
    """A scene of MuJoCo and the shots of a measured set, in parts of whole recordings.

    Attributes:
        set: name of the set.
        model: the scene.
        nominal: what the scene does, by its audit.
        shots: of the set.
        part: (B,) number of the part of each shot.
        scratch: folder of verdicts on the set.
    """

    set: str
    model: PublishedModel
    nominal: Simulator
    shots: Shots
    part: NDArray[int64]
    scratch: Path

    def diagnosis(self, number: int) -> Diagnosis:
        """Return the diagnosis of the scene on all parts but one."""
        file = f"{self.model.name.replace('/', '-')}.{number}.json"
        return Diagnosis(self.scratch / file, self.shots[self.part != number], self.nominal)

    def errors(self, number: int, verdict: Verdict) -> Floats:
        """Return how far the shots of a part are from predictions that MuJoCo flies.

        Args:
            number: of the part.
            verdict: on the other parts.

        Returns:
            (3, B, 3) m at the horizons: of the scene as it is, of the amended code, and of this
            code on simulated replicates of the shots, means over replicates.

        Raises:
            EngineError: the scene fails.
        """
        after, scene = amended(self.nominal, verdict), self.model.scene_of_mujoco()
        fit = _read(self.shots[self.part != number], lambda shots: _refit(shots, after))
        noise = fit.noise_estimate.noise
        fits = (_refit(fit.linear.shots, self.nominal), fit)
        spins = [result.typical_spin(DEFAULTS.name.min_spin) for result in fits]
        step = float(scene.model.opt.timestep)
        code = CodeEngine(scene.name, ball_effects(after, scene.name, [], "mujoco"), scene)
        as_it_is = FlownPredictions(scene, step, self.nominal, noise, spins[0])
        coded = FlownPredictions(code, step, after, noise, spins[1])
        shots = self.shots[self.part == number]
        held_fit = _read(shots, lambda read: fit_nuisance(read, after, noise, DEFAULTS.fit))
        held = HeldOut.of(held_fit, shots, noise, DEFAULTS)
        flown = [engine.distances(held.shots, held.usable) for engine in (as_it_is, coded)]
        return np.stack([*flown, _floor(coded, held)])


def _refit(shots: Shots, simulator: Simulator) -> RefitResult:
    return refit(shots, simulator, (), DEFAULTS.fit)


def _read(shots: Shots, fit: Callable[[Shots], RefitResult]) -> RefitResult:
    """Return the fit of shots whose labels are read as their paths say."""
    result = fit(shots)
    readings = read_labels(shots, result, DEFAULTS)
    return fit(readings.corrected(shots)) if readings.doubtful else result


def _floor(predictions: FlownPredictions, held: HeldOut) -> Floats:
    """Return (B, 3) m, the errors on replicates that the list of effects simulates."""
    simulator, random = predictions.simulator, np.random.default_rng(0)
    kicks, count = DEFAULTS.fit.max_kicks, DEFAULTS.verify.replicates
    replicates = [
        simulate_replicate(held.shots, simulator, held.states, held.noise, kicks, random)
        for _ in range(count)
    ]
    tries = [predictions.distances(replicate, held.usable) for replicate in replicates]
    return np.asarray(np.stack(tries).mean(axis=0))


def real_scenes(root: Path, folder: Path) -> dict[str, dict[str, Any]]:
    """Write and return errors before and after amending, by set and scene.

    Args:
        root: of the repository.
        folder: with a folder for each set.

    Raises:
        InputError: a set cannot be read, or the experiment cannot start.
    """
    sets = {name: read_shots(folder / name, name).shots for name in SETS}
    data = " ".join(fingerprint(root, shots, PARTS) for shots in sets.values())
    with running(root, "simulator_scenes.real", data=data) as run:
        content = _tested(
            [scene for named in sets.items() for scene in _scenes(*named, run.scratch)]
        )
        write_json(root / REPORT, content)
    return content


def _scenes(name: str, shots: Shots, scratch: Path) -> Iterator[MeasuredScene]:
    """Yield the scenes of a set."""
    part = fold_numbers(name, shots.groups, PARTS)
    for model in PUBLISHED:
        if model.name in SCENES:
            nominal = audited(model.build(), patience=inf).simulator
            yield MeasuredScene(name, model, nominal, shots, part, scratch / name)


def _tested(scenes: Sequence[MeasuredScene]) -> dict[str, dict[str, Any]]:
    """Return what is written of every scene, by set and scene."""
    parts = [(scene, number) for scene in scenes for number in range(PARTS)]
    results = verdicts([scene.diagnosis(number) for scene, number in parts], "verdicts")
    tasks = [
        partial(scene.errors, number, verdict)
        for (scene, number), verdict in zip(parts, results, strict=True)
    ]
    errors = list(parallel(tasks, "flights"))
    content: dict[str, dict[str, Any]] = {}
    for first, scene in zip(range(0, len(parts), PARTS), scenes, strict=True):
        own = slice(first, first + PARTS)
        result = _result(results[own], np.concatenate(errors[own], axis=1))
        content.setdefault(scene.set, {})[scene.model.name] = result
    return content


def _result(results: Sequence[Verdict], errors: Floats) -> dict[str, Any]:
    """Return what is written of a scene on a set.

    Args:
        results: verdicts, one for each part that is held out.
        errors: (3, B, 3) m, NaN where a shot has none.
    """
    before, after, floor = np.nanmean(errors, axis=1)
    # The 95 % interval of the mean fall of a shot's errors over its horizons.
    falls = errors[0] - errors[1]
    falls = np.nanmean(falls[np.isfinite(falls).any(axis=1)], axis=1)
    drawn = drawn_shots(len(falls), DEFAULTS.verify.bootstrap_draws)
    fall = np.array(interval(falls[drawn].mean(axis=1), DEFAULTS.confidence))
    return {
        "horizons_ms": [round(MS * horizon) for horizon in HORIZONS],
        "shots": np.isfinite(errors[0]).sum(axis=0).tolist(),
        "before_mm": _rounded(before),
        "after_mm": _rounded(after),
        "floor_mm": _rounded(floor),
        "fall_mm": _rounded(fall),
        "verdicts": [verdict.verdict for verdict in results],
        "leading": [
            [cause.identity for cause in verdict.causes if cause.role == "leading"]
            for verdict in results
        ],
    }


def _rounded(sizes: Floats) -> list[float]:
    return [round(MM * float(size), 1) for size in sizes]


if __name__ == "__main__":
    try:
        real_scenes(repository_root(), Path(os.environ.get("RALLYGAP_DATA", "")))
    except InputError as error:
        refuse(error)
