"""Errors of predictions that an engine flies, on shots that were held out.

They are measured as those of a verdict are (``models/gap/verify/prediction_error.py``): a shot is
fitted on its first samples alone, about the list of effects that stands for the engine, and the
sensor is that of the list. But the engine itself flies from there.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_interp_spline

from rallygap.models.ball.sensor import delays, measured_positions, true_times
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, VELOCITY
from rallygap.models.ball.types import Floats
from rallygap.models.engines.engine import Engine
from rallygap.models.gap.fit.horizons import at_horizons, first_samples, last_observed_time
from rallygap.models.gap.fit.linearize import ballistic_nuisance
from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.shot_fit import fit_shots, refit_shots
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.settings import DEFAULTS
from rallygap.models.gap.types import Bools

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
        squares = ((shots.positions - self._measured(self._launches(shots), since)) ** 2).sum(
            axis=2
        )
        roots: Floats = np.sqrt(at_horizons(shots, squares, usable, HORIZONS, DEFAULTS))
        return roots

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
    found = [
        make_interp_spline(marks, path, k=1)(when)
        for path, when in zip(paths, moments, strict=True)
    ]
    return np.stack(found)
