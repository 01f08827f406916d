"""Shot fit: every shot's own unknowns, given a simulator; B shots at once.

Levenberg-Marquardt on the posterior of the state and the kicks with independent noise of one size;
what is correlated comes later, on the linearised shots. The noise starts large and shrinks, which
leads outliers and poor starts past the local minima that a sharp likelihood has (graduated
non-convexity), and the horizon starts short, so that a ball bounces where it did.
"""

from dataclasses import dataclass, replace

import numpy as np

from models.ball.simulator import Simulator
from models.ball.types import Floats
from models.gap.fit.linearize import ballistic_unknowns, label_units
from models.gap.fit.measurement import JUMP, Moments, Seen, bounces, by_unknowns, seen
from models.gap.fit.noise import Noise, inlier_probability, prior_precision, surprise
from models.gap.fit.shots import Shots
from models.gap.types import Bools, Indices

MOST_KICKS = 2  # bounces of a shot that may scatter
FIRST_HORIZON = 0.12  # s
FALL = np.array([0.0, 0.0, -9.81])
# Noise (m), horizon (s) and iterations of each stage.
STAGES = ((0.03, FIRST_HORIZON, 3), (0.03, np.inf, 3), (0.01, np.inf, 2))
DAMPING = 1e-3  # to begin with
# Change of -2 log likelihood at which a shot's fit has settled: what is left of it is linear.
ENOUGH = 0.1
MOST_ITERATIONS = 10
SPIN = 300.0  # rad/s, about a component of a spin without a label
# The noise is guessed by its large errors, though not by outliers: where the simulator is wrong
# about bounces, the samples after them must not pass for outliers.
MOST, NORMAL_MOST = 0.9, 1.645  # quantile of a standard normal's size
LEAST_NOISE = 1e-4  # m
NORMAL_SPREAD = 1.4826  # standard deviation over median size of a normal
FAR = 2.0  # times the noise that residuals typically are, from where the noise must shrink first
# What unknowns may be, so that no flight diverges: m, m/s, rad/s, and kicks.
WORLD, MOST_KICK = np.repeat([1e4, 150.0, 5000.0], 3), 3.0


@dataclass(frozen=True)
class ShotFit:
    """Fitted unknowns of B shots.

    Attributes:
        unknowns: (B, 9 + 3 K) states at the first sample, and kicks.
        weights: (B, N) probabilities that samples are no outliers; 0 in padding.
        noise: with which they were fitted.
        cost: (B,) twice the negative log likelihoods, where outliers cost no more than they do.
    """

    unknowns: Floats
    weights: Floats
    noise: Noise
    cost: Floats

    def with_better(self, rows: Indices, other: "ShotFit") -> "ShotFit":
        """Return the shots with those of ``rows`` as another fit has them where that is better."""
        found = other.cost < self.cost[rows]
        taken = rows[found]
        unknowns, weights, cost = self.unknowns.copy(), self.weights.copy(), self.cost.copy()
        unknowns[taken], weights[taken] = other.unknowns[found], other.weights[found]
        cost[taken] = other.cost[found]
        return replace(self, unknowns=unknowns, weights=weights, cost=cost)


def fit_shots(shots: Shots, simulator: Simulator) -> ShotFit:
    """Fit the unknowns of shots from scratch, and guess the noise from what is left."""
    moments = Moments.of(shots)
    unknowns, noise = _start(shots), Noise()
    for size, horizon, iterations in STAGES:
        stage = _Problem.of(shots, simulator, replace(noise, white=size, slow=0.0), horizon)
        unknowns = stage.solved(unknowns, iterations)
    kicks = min(int(bounces(simulator, moments, unknowns).max(initial=0)), MOST_KICKS)
    large = np.quantile(np.abs(stage.at(unknowns).residual[shots.valid]), MOST)
    white = max(float(large) / NORMAL_MOST, LEAST_NOISE)
    noise = replace(noise, white=white, slow=white / 3)
    return refit_shots(shots, simulator, ballistic_unknowns(unknowns, kicks), noise)


def refit_shots(
    shots: Shots,
    simulator: Simulator,
    unknowns: Floats,
    noise: Noise,
    iterations: int = MOST_ITERATIONS,
    spin: float = SPIN,
) -> ShotFit:
    """Fit the unknowns of shots from where they are.

    Args:
        shots: measured.
        simulator: to fit them with.
        unknowns: (B, 9 + 3 K) where to start.
        noise: by which labels and samples are weighed.
        iterations: at most; few are enough near the best fit.
        spin: rad/s, size of a component of a spin without a label.
    """
    problem = replace(_Problem.of(shots, simulator, noise, np.inf), spin=spin)
    far = problem.typical(unknowns) / noise.position
    if far > FAR:
        wide = replace(problem, noise=noise.widened(far))
        unknowns = wide.solved(unknowns, iterations)
    fitted = problem.solved(unknowns, iterations)
    return problem.found(fitted)


@dataclass(frozen=True)
class _Point:
    """Where a fit is: unknowns, what they predict, and how far that is off.

    Residuals are those of positions in m, steadied; errors those of labels in units of their
    noise, which ``scale`` (B, L) converts to, zero where there is no label.
    """

    unknowns: Floats
    view: Seen
    residual: Floats
    errors: Floats
    scale: Floats
    weights: Floats


@dataclass(frozen=True)
class _Problem:
    shots: Shots
    simulator: Simulator
    noise: Noise
    moments: Moments
    used: Bools
    spin: float = SPIN

    @property
    def label_times(self) -> Floats:
        """(B, L) s from the first sample."""
        return self.shots.label_times - self.shots.times[:, :1]

    @classmethod
    def of(cls, shots: Shots, simulator: Simulator, noise: Noise, horizon: float) -> "_Problem":
        used = shots.valid & (shots.times - shots.times[:, :1] <= horizon)
        return cls(shots, simulator, noise, Moments.of(shots), used)

    def __getitem__(self, rows: Indices) -> "_Problem":
        return replace(
            self, shots=self.shots[rows], moments=self.moments[rows], used=self.used[rows]
        )

    def solved(self, unknowns: Floats, iterations: int) -> Floats:
        reach = np.concatenate([WORLD, np.full(unknowns.shape[1] - len(WORLD), MOST_KICK)])
        unknowns, damping = np.clip(unknowns, -reach, reach), np.full(len(unknowns), DAMPING)
        moving = np.arange(len(unknowns))
        for _ in range(iterations):
            some = self[moving]
            point = some.at(unknowns[moving])
            step = some._step(point, damping[moving])
            trial = some.at(np.clip(point.unknowns + step, -reach, reach))
            gain = some._cost(point, point.weights) - some._cost(trial, point.weights)
            better = gain >= 0.0
            unknowns[moving[better]] = trial.unknowns[better]
            damping[moving] *= np.where(better, 0.1, 10.0)
            moving = moving[np.abs(gain) > ENOUGH]
            if len(moving) == 0:
                break
        return unknowns

    def found(self, unknowns: Floats) -> ShotFit:
        """Return where a fit has come to."""
        point = self.at(unknowns)
        cost = np.where(self.used, surprise(point.residual, self.noise), 0.0).sum(axis=1)
        cost += (point.errors**2).sum(axis=(1, 2))
        cost += (self._precision(unknowns) * unknowns**2).sum(axis=1)
        return ShotFit(unknowns, point.weights, self.noise, cost)

    def typical(self, unknowns: Floats) -> float:
        """Return the standard deviation of a normal with residuals of this median size, m."""
        sizes = np.abs(self.at(unknowns).residual[self.used])
        return NORMAL_SPREAD * float(np.median(sizes))

    def at(self, unknowns: Floats) -> _Point:
        view = seen(self.simulator, self.moments, unknowns)
        miss = np.where(self.used[..., None], self.shots.positions - view.positions, 0.0)
        residual = self.noise.steadied(miss[..., None], view.velocities)[..., 0]
        used = self.shots.labelled & view.smooth(self.label_times, JUMP)
        scale = used / (label_units(view.labels) * self._label_error()[:, None])
        errors = np.nan_to_num(self.shots.labels - view.labels) * scale[..., None]
        weights = np.where(self.used, inlier_probability(residual, self.noise), 0.0)
        return _Point(unknowns, view, residual, errors, scale, weights)

    def _label_error(self) -> Floats:
        """Return (B,) the error of a label in units of the spin, as if independent in every row."""
        count = np.maximum(self.shots.labelled.sum(axis=1), 1)
        error: Floats = np.sqrt(self.noise.label**2 + count * self.noise.label_common**2)
        return error

    def _precision(self, unknowns: Floats) -> Floats:
        labelled = np.asarray(self.shots.labelled.any(axis=1))
        return prior_precision(~labelled, unknowns.shape[1], self.noise, self.spin)

    def _cost(self, point: _Point, weights: Floats) -> Floats:
        cost = (weights[..., None] * point.residual**2).sum(axis=(1, 2)) / self.noise.position**2
        cost += (point.errors**2).sum(axis=(1, 2))
        prior = self._precision(point.unknowns)
        total: Floats = cost + (prior * point.unknowns**2).sum(axis=1)
        return total

    def _step(self, point: _Point, damping: Floats) -> Floats:
        count, size = point.unknowns.shape
        slopes = by_unknowns(self.simulator, self.moments, point.unknowns, point.view)
        scale = np.sqrt(point.weights)[..., None] / self.noise.position
        paths = self.noise.steadied(slopes.positions, point.view.velocities)
        rows = np.concatenate(
            [
                (paths * scale[..., None]).reshape(count, -1, size),
                (slopes.labels * point.scale[..., None, None]).reshape(count, -1, size),
            ],
            axis=1,
        )
        misses = (point.residual * scale).reshape(count, -1), point.errors.reshape(count, -1)
        prior = self._precision(point.unknowns)
        normal = np.swapaxes(rows, 1, 2) @ rows + prior[:, :, None] * np.eye(size)
        gradient = np.einsum("bre,br->be", rows, np.concatenate(misses, axis=1))
        diagonal = np.einsum("bii->bi", normal)
        diagonal *= 1 + damping[:, None]
        diagonal += 1e-12 * diagonal.max(axis=1, keepdims=True)
        pull = (gradient - prior * point.unknowns)[..., None]
        step: Floats = np.linalg.solve(normal, pull)[..., 0]
        return step


def _start(shots: Shots) -> Floats:
    """Return (B, 9) states: a ballistic line through the first samples, and the first label."""
    t = shots.times - shots.times[:, :1]
    early = shots.valid & (t <= FIRST_HORIZON)
    early[:, :4] |= shots.valid[:, :4]
    falling = shots.positions - 0.5 * FALL * t[..., None] ** 2
    weights = early.astype(np.float64)
    for _ in range(8):
        line = _line(t, falling, weights)
        miss = np.linalg.norm(
            falling - line[:, None, :3] - t[..., None] * line[:, None, 3:], axis=2
        )
        typical = np.nanmedian(np.where(early, miss, np.nan), axis=1)[:, None] + 1e-3
        weights = np.where(early, 1 / (1 + (miss / typical) ** 2), 0.0)
    spin = np.nan_to_num(shots.labels[:, 0]) if shots.labels.shape[1] else np.zeros((len(t), 3))
    return np.concatenate([line, spin], axis=1)


def _line(t: Floats, places: Floats, weights: Floats) -> Floats:
    """Return (B, 6) place at time zero and velocity of weighted lines."""
    w = weights[..., None]
    total = w.sum(axis=1)
    mean_t, mean_p = (w * t[..., None]).sum(axis=1) / total, (w * places).sum(axis=1) / total
    since = t[..., None] - mean_t[:, None]
    spread = np.maximum((w * since**2).sum(axis=1), 1e-12)
    velocity = (w * since * places).sum(axis=1) / spread
    return np.concatenate([mean_p - velocity * mean_t, velocity], axis=1)
