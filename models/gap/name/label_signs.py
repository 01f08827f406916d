"""Label signs: shots whose spin label is negated.

A shot is fitted with its label and with the negated label. Where the latter fits decisively better,
and as well as other shots do, the label is flipped. The share of such shots is the effect
``spin_sign_flip``.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import binomtest

from models.ball.simulator import Simulator
from models.ball.state import SPIN
from models.ball.types import Floats
from models.gap.fit.linearize import linearise
from models.gap.fit.noise import Noise, deviance
from models.gap.fit.refit import RefitResult
from models.gap.fit.shot_fit import refit_shots
from models.gap.fit.shots import Shots
from models.gap.settings import FitSettings, GapSettings
from models.gap.types import Bools


@dataclass(frozen=True)
class LabelSigns:
    """Which labels are flipped.

    Attributes:
        flipped: numbers of the shots whose labels are flipped.
        labelled: how many shots have labels.
        settings: of the workflow.
    """

    flipped: frozenset[int]
    labelled: int
    settings: GapSettings

    @property
    def share(self) -> float:
        """Of flipped labels in the labelled shots."""
        return float(len(self.flipped) / max(self.labelled, 1))

    @property
    def interval(self) -> tuple[float, float]:
        """Of the share (Wilson 1927)."""
        test = binomtest(len(self.flipped), max(self.labelled, 1))
        ends = test.proportion_ci(self.settings.confidence, "wilson")
        return float(ends.low), float(ends.high)

    @property
    def significant(self) -> bool:
        """Whether enough shots are flipped for a verdict."""
        return len(self.flipped) >= self.settings.name.min_flipped_labels

    @property
    def detectable(self) -> float:
        """The smallest share that would be found."""
        return self.settings.name.min_flipped_labels / max(self.labelled, 1)

    def corrected(self, shots: Shots) -> Shots:
        """Return shots with the flipped labels negated, if they are significant."""
        return self.negated(shots) if self.significant else shots

    def negated(self, shots: Shots) -> Shots:
        """Return shots with the flipped labels negated."""
        sign = np.ones((len(shots), 1, 1))
        sign[sorted(self.flipped)] = -1.0
        return replace(shots, labels=shots.labels * sign)

    def left_out(self, shots: Shots) -> Shots:
        """Return shots without the flipped labels."""
        times, labels = shots.label_times.copy(), shots.labels.copy()
        times[sorted(self.flipped)] = labels[sorted(self.flipped)] = np.nan
        return replace(shots, label_times=times, labels=labels)


def no_flipped_labels(shots: Shots, settings: GapSettings) -> LabelSigns:
    """Return that no label is flipped."""
    return LabelSigns(frozenset(), _labelled(shots).sum().item(), settings)


def find_flipped_labels(shots: Shots, fit: RefitResult, settings: GapSettings) -> LabelSigns:
    """Return which labels the paths of their shots contradict."""
    none = no_flipped_labels(shots, settings)
    if not none.labelled:
        return none
    flipped = np.flatnonzero(_flipped(shots, fit, settings)).tolist()
    return replace(none, flipped=frozenset(flipped))


def _labelled(shots: Shots) -> Bools:
    return np.asarray(shots.labelled.any(axis=1))


def _flipped(shots: Shots, fit: RefitResult, settings: GapSettings) -> Bools:
    limits, labelled = settings.name, _labelled(shots)
    shots = shots.corrected(fit.camera_errors)
    simulator, noise, nuisance = fit.simulator, fit.noise_estimate.noise, fit.linear.nuisance
    misfit = _misfit(shots, simulator, nuisance, noise, settings.fit)
    rows = shots.valid.sum(axis=1) + shots.labelled.sum(axis=1)
    typical = np.median((misfit / rows)[labelled])
    tried = np.flatnonzero(labelled & (misfit > limits.suspect_misfit * typical * rows))
    flipped = np.zeros(len(shots), dtype=bool)
    if len(tried):
        negated = replace(shots[tried], labels=-shots.labels[tried])
        start = nuisance[tried].copy()
        start[:, SPIN] *= -1.0
        refitted = refit_shots(negated, simulator, start, noise, settings.fit)
        other = _misfit(negated, simulator, refitted.nuisance, noise, settings.fit)
        better = other < misfit[tried] - settings.decisive_gain(int(labelled.sum()))
        flipped[tried] = better & (other < limits.ordinary_misfit * typical * rows[tried])
    return flipped


def _misfit(
    shots: Shots, simulator: Simulator, nuisance: Floats, noise: Noise, settings: FitSettings
) -> Floats:
    """Return (B,) twice the negative log likelihoods, of positions as when shots are fitted."""
    linear = linearise(shots, simulator, nuisance, ())
    deviances = deviance(linear.positions[..., -1], noise, settings)
    places = np.where(linear.sampled, deviances, 0.0).sum(axis=1)
    variance = noise.label_variance(*linear.label_counts)
    labels = ((linear.labels[..., -1] ** 2).sum(axis=2) / variance).sum(axis=1)
    return np.asarray(places + labels, dtype=np.float64)
