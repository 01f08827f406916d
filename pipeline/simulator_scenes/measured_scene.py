"""A scene on a measured set: diagnosed on some recordings, and tested in MuJoCo on the others."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy import int64
from numpy.typing import NDArray

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.refit import RefitResult, fit_nuisance, refit
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.name.label_readings import read_labels
from rallygap.models.gap.settings import DEFAULTS
from rallygap.models.gap.verdict import Verdict
from rallygap.models.gap.verify.prediction_error import HeldOut
from rallygap.models.gap.verify.replicates import simulate_replicate
from rallygap.pipeline.engines.export.code import ball_effects
from rallygap.pipeline.known_answers.answers import Diagnosis
from rallygap.pipeline.simulator_scenes.held_out_flights import FlownPredictions
from rallygap.pipeline.simulator_scenes.published import PublishedModel


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
        from rallygap.pipeline.engines.export.scene.coded_ball import CodedBall

        after, scene = amended(self.nominal, verdict), self.model.scene_of_mujoco()
        fit = _read(self.shots[self.part != number], lambda shots: _refit(shots, after))
        noise = fit.noise_estimate.noise
        fits = (_refit(fit.linear.shots, self.nominal), fit)
        spins = [one.typical_spin(DEFAULTS.name.min_spin) for one in fits]
        step = float(scene.model.opt.timestep)
        code = CodedBall(scene.name, ball_effects(after, scene.name, [], "mujoco"), scene)
        as_it_is = FlownPredictions(scene, step, self.nominal, noise, spins[0])
        coded = FlownPredictions(code, step, after, noise, spins[1])
        held = _held(self.shots[self.part == number], after, noise)
        flown = [one.distances(held.shots, held.usable) for one in (as_it_is, coded)]
        return np.stack([*flown, _floor(coded, held)])


def _refit(shots: Shots, simulator: Simulator) -> RefitResult:
    return refit(shots, simulator, (), DEFAULTS.fit)


def _read(shots: Shots, fit: Callable[[Shots], RefitResult]) -> RefitResult:
    """Return the fit of shots whose labels are read as their paths say."""
    found = fit(shots)
    readings = read_labels(shots, found, DEFAULTS)
    return fit(readings.corrected(shots)) if readings.doubtful else found


def _held(shots: Shots, simulator: Simulator, noise: Noise) -> HeldOut:
    fit = _read(shots, lambda read: fit_nuisance(read, simulator, noise, DEFAULTS.fit))
    return HeldOut.of(fit, shots, noise, DEFAULTS)


def _floor(predictions: FlownPredictions, held: HeldOut) -> Floats:
    """Return (B, 3) m, the errors on replicates that the list of effects simulates."""
    simulator, random = predictions.simulator, np.random.default_rng(0)
    kicks, count = DEFAULTS.fit.max_kicks, DEFAULTS.verify.replicates
    replicates = [
        simulate_replicate(held.shots, simulator, held.states, held.noise, kicks, random)
        for _ in range(count)
    ]
    tries = np.stack([predictions.distances(one, held.usable) for one in replicates])
    means: Floats = tries.mean(axis=0)
    return means
