"""Smoothed arcs: measured trajectories between two bounces.

Each arc is fitted by the nominal simulator, and its small residuals by a parabola. Spins are those
of the labels where an arc has any.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.polynomial.legendre import legder, legvander

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, SPIN, STATE_SIZE, VELOCITY
from rallygap.models.ball.types import Bools, Floats, Integers
from rallygap.models.gap.fit.measurement import JUMP, Schedule, predict_measurements
from rallygap.models.gap.fit.shot_fit import fit_shots
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.settings import FitSettings

DEGREE = 4  # of the polynomials that describe residuals of an arc
SMOOTH = 2  # highest degree that is taken for motion rather than noise
MINIMUM_SAMPLES = 10  # of an arc
NEAR_BOUNCE = 2e-3  # s; samples closer to a bounce may belong to either arc
MINIMUM_WEIGHT = 0.5  # of a sample that is used


@dataclass(frozen=True)
class SmoothedArcs:
    """R arcs, smoothed."""

    shots: Shots  # the samples and labels of each, as measured
    parents: Integers  # (R,) the shot of each
    starts: Floats  # (R,) s on the sensor's clock, the bounce before it, -inf if there is none
    ends: Floats  # (R,) the bounce after it, inf if there is none
    simulator: Simulator  # nominal, without contacts
    states: Floats  # (R, 9) its fit at the first samples
    spins: Floats  # (R, 3) mean difference of labels from its spins, rad/s
    columns: Floats  # (R, N, D + 1) orthonormal polynomials at the samples, zero for outliers
    mixing: Floats  # (R, D + 1, D + 1) their coefficients in Legendre polynomials
    residuals: Floats  # (R, D + 1, 3) of the fit, as coefficients of these polynomials

    @classmethod
    def of(cls, whole: Shots, simulator: Simulator) -> "SmoothedArcs":
        """Cut shots at the bounces of a simulator's fit; smooth arcs about a fit of each."""
        shots, parents, starts, ends = _arcs(whole, simulator)
        free = simulator.without_surfaces()
        fit = fit_shots(shots, free, FitSettings())
        prediction = predict_measurements(free, Schedule.of(shots), fit.nuisance)
        usable = shots.valid & (fit.weights > MINIMUM_WEIGHT)
        rows = legvander(scaled(shots, shots.times), DEGREE) * usable[..., None]
        columns, triangle = np.linalg.qr(rows)
        residual = (shots.positions - prediction.positions) * usable[..., None]
        apart = np.where(shots.labelled[..., None], shots.labels - prediction.labels, 0.0).sum(
            axis=1
        )
        return cls(
            shots,
            parents,
            starts,
            ends,
            free,
            fit.nuisance[:, :STATE_SIZE],
            apart / np.maximum(shots.labelled.sum(axis=1), 1)[:, None],
            columns,
            np.linalg.inv(triangle),
            np.swapaxes(columns, 1, 2) @ residual,
        )

    @property
    def labelled(self) -> Bools:
        """(R,) which have a spin label."""
        return np.asarray(self.shots.labelled.any(axis=1))

    @property
    def spans(self) -> Floats:
        """(R,) s from the first sample to the last."""
        return np.ptp(self.shots.times, axis=1)

    def times(self, places: Floats) -> Floats:
        """Return (R, T) times on the sensor's clock at places between -1 and 1 along an arc."""
        first = self.shots.times[:, :1]
        return first + self.spans[:, None] * (places + 1.0) / 2.0

    def fitted(self, times: Floats) -> Floats:
        """Return the (R, T, 9) states of the fit at times on the sensor's clock."""
        return self.simulator.fly(self.states, times - self.shots.times[:, :1]).states

    def smooth(self, times: Floats) -> Floats:
        """Return the (R, T, 9) smoothed states at increasing times on the sensor's clock."""
        states, place = self.fitted(times).copy(), scaled(self.shots, times)
        kept = np.arange(DEGREE + 1) <= SMOOTH
        series = self.mixing @ (self.residuals * kept[:, None])
        slopes = legder(np.eye(DEGREE + 1)).T
        states[..., POSITION] += legvander(place, DEGREE) @ series
        rates = legvander(place, DEGREE - 1) @ (slopes.T @ series)
        states[..., VELOCITY] += rates * (2.0 / self.spans)[:, None, None]
        states[..., SPIN] += self.spins[:, None]
        return states

    def at_bounces(self, offset: float) -> tuple[Floats, Floats]:
        """Return (R, 9) states ``offset`` s before the ends of arcs, and after their starts."""
        times = self.shots.times
        ends = np.where(np.isfinite(self.ends), self.ends - offset, times[:, -1])
        starts = np.where(np.isfinite(self.starts), self.starts + offset, times[:, 0])
        return self.smooth(ends[:, None])[:, 0], self.smooth(starts[:, None])[:, 0]


def _arcs(shots: Shots, simulator: Simulator) -> tuple[Shots, Integers, Floats, Floats]:
    """Cut shots at the bounces of a fit with bounce scatter; return arcs, parents, starts, ends."""
    fit = fit_shots(shots, simulator, FitSettings())
    prediction = predict_measurements(simulator, Schedule.of(shots), fit.nuisance)
    since = shots.times - shots.times[:, :1]
    usable = (
        shots.valid & (fit.weights > MINIMUM_WEIGHT) & ~(since > prediction.smooth_until[:, None])
    )
    pieces = []
    for shot, contacts in enumerate(prediction.contacts + shots.times[:, :1]):
        times, when = shots.times[shot], shots.label_times[shot]
        bounces = np.sort(contacts[np.isfinite(contacts)])
        for start, end in pairwise([-np.inf, *bounces, np.inf]):
            inside = usable[shot] & (times > start + NEAR_BOUNCE) & (times < end - NEAR_BOUNCE)
            labels = (when > start + JUMP) & (when < end - JUMP)
            if inside.sum() >= MINIMUM_SAMPLES:
                samples = times[inside], shots.positions[shot, inside]
                labelled = shots.labels[shot, labels], when[labels]
                pieces.append((*samples, *labelled, shot, start, end))
    *measured, parents, starts, ends = zip(*pieces, strict=True)
    return Shots.from_arrays(*measured), np.array(parents), np.array(starts), np.array(ends)


def scaled(shots: Shots, times: Floats) -> Floats:
    """Return (R, T) times on the sensor's clock, scaled to -1 to 1 along an arc."""
    first, last = shots.times[:, :1], shots.times[:, -1:]
    return 2.0 * (times - first) / (last - first) - 1.0
