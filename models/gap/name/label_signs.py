"""Signs: shots whose spin label reads backwards.

Whether a label is negated is a question to one shot at a time: it is fitted with the label as it is
and with the label negated. Where the latter fits far better, and as well as shots do, the label is
backwards. The share of such shots is the effect ``spin_sign_flip``; the rest of the workflow sees
them with their signs put right, or leaves them out as long as that is in doubt.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import binomtest

from models.ball.simulator import Simulator
from models.ball.state import SPIN
from models.ball.types import Floats
from models.gap.fit.linearize import linearise
from models.gap.fit.noise import OUTLIER_SIZE, OUTLIERS, Noise
from models.gap.fit.refit import Refitted
from models.gap.fit.shot_fit import refit_shots
from models.gap.fit.shots import Shots

FEWEST = 3  # shots: no verdict rests on one or two
DECISIVE = 20.0  # of twice the log likelihood
DOUBTFUL = 1.1  # times the typical error from which a shot is asked
ORDINARY = 2.0  # times the typical error up to which a shot fits as shots do


@dataclass(frozen=True)
class Signs:
    """Which labels are backwards.

    Attributes:
        count: of shots in all.
        backwards: numbers of the shots whose labels are.
        labelled: how many shots have labels.
    """

    count: int
    backwards: frozenset[int]
    labelled: int

    @property
    def share(self) -> float:
        """Of the labelled shots."""
        return float(len(self.backwards) / max(self.labelled, 1))

    @property
    def interval(self) -> tuple[float, float]:
        """95 % of the share."""
        found = binomtest(len(self.backwards), max(self.labelled, 1))
        ends = found.proportion_ci(0.95, "wilson")
        return float(ends.low), float(ends.high)

    @property
    def significant(self) -> bool:
        """Whether more shots say so than no verdict rests on."""
        return len(self.backwards) >= FEWEST

    @property
    def detectable(self) -> float:
        """The smallest share that would be found."""
        return FEWEST / max(self.labelled, 1)

    def righted(self, shots: Shots) -> Shots:
        """Return shots with the signs of their labels put right, if that many are wrong."""
        if not self.significant:
            return shots
        turn = np.ones((self.count, 1, 1))
        turn[sorted(self.backwards)] = -1.0
        return replace(shots, labels=shots.labels * turn)

    def left_out(self, shots: Shots) -> Shots:
        """Return shots without the labels that are backwards."""
        times, labels = shots.label_times.copy(), shots.labels.copy()
        times[sorted(self.backwards)] = labels[sorted(self.backwards)] = np.nan
        return replace(shots, label_times=times, labels=labels)


def no_signs(shots: Shots) -> Signs:
    """Return that all labels read as they should."""
    labelled = shots.labelled.any(axis=1)
    return Signs(len(shots), frozenset(), int(labelled.sum()))


def signs(shots: Shots, found: Refitted) -> Signs:
    """Return which labels are backwards, as far as their balls' paths tell."""
    labelled = shots.labelled.any(axis=1)
    backwards = np.zeros(len(shots), dtype=bool)
    if labelled.any():
        simulator, noise, unknowns = found.simulator, found.components.noise, found.linear.unknowns
        as_is = _misfit(shots, simulator, unknowns, noise)
        rows = shots.valid.sum(axis=1) + shots.labelled.sum(axis=1)
        typical = np.median((as_is / rows)[labelled])
        asked = np.flatnonzero(labelled & (as_is > DOUBTFUL * typical * rows))
        if len(asked):
            turned = replace(shots[asked], labels=-shots.labels[asked])
            start = unknowns[asked].copy()
            start[:, SPIN] *= -1.0
            fit = refit_shots(turned, simulator, start, noise)
            other = _misfit(turned, simulator, fit.unknowns, noise)
            better = other < as_is[asked] - DECISIVE
            backwards[asked] = better & (other < ORDINARY * typical * rows[asked])
    numbers = frozenset(np.flatnonzero(backwards).tolist())
    return Signs(len(shots), numbers, int(labelled.sum()))


def _misfit(shots: Shots, simulator: Simulator, unknowns: Floats, noise: Noise) -> Floats:
    """Return (B,) twice the negative log likelihoods, where outliers cost no more than they do."""
    linear = linearise(shots, simulator, unknowns, ())
    distance = (linear.positions[..., -1] ** 2).sum(axis=2) / noise.position**2
    ratio = noise.position / OUTLIER_SIZE
    density = (1 - OUTLIERS) * np.exp(-distance / 2) + OUTLIERS * ratio**3
    places = -2 * np.where(linear.sampled, np.log(density), 0.0).sum(axis=1)
    count = np.maximum(linear.labelled.sum(axis=1), 1)
    variance = noise.label**2 + count * noise.label_common**2
    labels = (linear.labels[..., -1] ** 2).sum(axis=(1, 2)) / variance
    misfit: Floats = places + labels
    return misfit
