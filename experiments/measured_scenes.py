"""Predictions of measured shots that a scene flies, as it is and amended.

Errors are measured as those of a verdict are (``models/gap/verify/prediction_error.py``): a shot is
fitted on its first samples alone, about the list of effects that stands for the engine, and the
sensor is that of the list. But the engine itself flies from there.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy import int64
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from experiments.resumed import Diagnosis
from experiments.simulators import PublishedModel
from rallygap.models.ball.sensor import delays, measured_positions, true_times
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, VELOCITY
from rallygap.models.ball.types import Floats
from rallygap.models.engines.engine import Engine
from rallygap.models.engines.mujoco.scene import MujocoScene
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
from rallygap.models.gap.verify.prediction_error import HeldOut
from rallygap.models.gap.verify.replicates import simulate_replicate
from rallygap.pipeline.engines.export.code import ball_effects
from rallygap.pipeline.engines.export.code_engine import CodeEngine

HORIZONS: Floats = np.array([0.1, 0.2, 0.3])  # s


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
        after, scene = amended(self.nominal, verdict), self.model.build()
        assert isinstance(scene, MujocoScene)
        settings = DEFAULTS.fit
        fit = _read(self.shots[self.part != number], lambda read: refit(read, after, (), settings))
        noise = fit.noise_estimate.noise
        fits = (refit(fit.linear.shots, self.nominal, (), settings), fit)
        spins = [result.typical_spin(DEFAULTS.name.min_spin) for result in fits]
        step = float(scene.model.opt.timestep)
        code = CodeEngine(scene.name, ball_effects(after, scene.name, [], "mujoco"), scene)
        as_it_is = FlownPredictions(scene, step, self.nominal, noise, spins[0])
        coded = FlownPredictions(code, step, after, noise, spins[1])
        shots = self.shots[self.part == number]
        held_fit = _read(shots, lambda read: fit_nuisance(read, after, noise, settings))
        held = HeldOut.of(held_fit, shots, noise, DEFAULTS)
        flown = [engine.distances(held.shots, held.usable) for engine in (as_it_is, coded)]
        random, count = np.random.default_rng(0), DEFAULTS.verify.replicates
        kicks = DEFAULTS.fit.max_kicks
        replicates = [
            simulate_replicate(held.shots, after, held.states, held.noise, kicks, random)
            for _ in range(count)
        ]
        tries = [coded.distances(replicate, held.usable) for replicate in replicates]
        return np.stack([*flown, np.stack(tries).mean(axis=0)])


def _read(shots: Shots, fit: Callable[[Shots], RefitResult]) -> RefitResult:
    """Return the fit of shots whose labels are read as their paths say."""
    result = fit(shots)
    readings = read_labels(shots, result, DEFAULTS)
    return fit(readings.corrected(shots)) if readings.doubtful else result
