"""Equivalent sizes: when another form of an effect counts as large as the catalogue's.

A physicist who fits the catalogue's form to balls of the independent world finds some size of it,
and some values of the simulator's own parameters. An independent world of a stated size is the one
in which this best fit, weighted like the trial's measurements, finds that size and leaves the own
parameters as they are. The fit is linear in the small difference between both worlds; the launch
state of each shot and the scatter of its bounce are fitted along.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from models.ball.catalogue import catalogue
from models.ball.simulator import Simulator
from models.ball.state import POSITION, SPIN, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from models.exam.design.trial import Trial
from models.exam.simulate.independent_ball import IndependentBall
from models.exam.simulate.launches import Launches
from models.exam.simulate.laws import FORMS, Physics, physics_of

Floats = NDArray[np.float64]

SHOTS = 100  # that the fit looks at
SAMPLES = 60  # a shot
NEAR_BOUNCE = 0.010  # s by which bounces of both worlds may differ
WELL_INSIDE = np.array([TABLE_HALF_WIDTH, TABLE_HALF_LENGTH]) - 0.05  # m
LEAST_ERROR = 1.0  # rad/s that even the label of a ball without spin is off
STATE_STEPS = np.array([1e-4] * 3 + [1e-3] * 3 + [0.5] * 3)
PARAMETER_STEP = 1e-3  # of the parameter's bounds
UNKNOWN_LAUNCH = 10.0  # m and m/s; as good as nothing known
UNLABELLED_SPIN = 150.0  # rad/s; what a candidate expects of a spin that nobody measured
NOT_OURS = ("racket_bounce", "net")  # nothing here meets them


Measured = Callable[..., Floats]  # of a ball, and of launch states


@dataclass(frozen=True)
class Fit:
    """A linear fit of parameters to the difference between two worlds.

    Attributes:
        parameters: (effect, parameter) of each fitted one.
        gain: (P, B, R) from residuals to changes of the parameters.
        errors: (P,) standard errors.
    """

    parameters: tuple[tuple[str, str], ...]
    gain: Floats
    errors: Floats

    def shifts(self, residuals: Floats) -> Floats:
        """Return the (P,) changes of the parameters that (B, R) residuals ask for."""
        found: Floats = np.einsum("pbr,br->p", self.gain, residuals)
        return found


def equivalent_physics(trial: Trial, launches: Launches) -> Physics:
    """Return the independent world in which a best fit finds the trial's causes.

    Raises:
        RuntimeError: there is none, because these shots do not show the effect.
    """
    simulator = trial.simulator
    physics = physics_of(simulator)
    if not set(trial.causes) & set(FORMS):
        return physics
    measured = _measured(trial, launches)
    fit = best_fit(trial, launches)
    names = [f"{effect}_{parameter}" for effect, parameter in fit.parameters]
    start = np.array([getattr(physics, name) for name in names])
    expected = measured(simulator)

    def constants(steps: Floats) -> Physics:
        return physics._replace(**dict(zip(names, start + steps * fit.errors, strict=True)))

    def misses(steps: Floats) -> Floats:
        residuals = measured(IndependentBall(constants(steps))) - expected
        return fit.shifts(residuals) / fit.errors

    solution = root(misses, np.zeros(len(names)), options={"xtol": 1e-4, "eps": 1e-4})
    if not np.abs(solution.fun).max() < 0.1:
        raise RuntimeError(f"{trial.name}: no independent world looks like its causes")
    return constants(solution.x)


def best_fit(trial: Trial, launches: Launches) -> Fit:
    """Return the fit of hidden causes and own parameters around the catalogue's world."""
    simulator, measured = trial.simulator, _measured(trial, launches)
    states = launches.states[:SHOTS]
    parameters = _fitted(trial)
    wanted = np.stack([_slope(measured, simulator, name) for name in parameters], axis=2)
    nuisance, prior = _nuisance(trial, states, measured)
    cross = np.swapaxes(nuisance, 1, 2)
    inner = cross @ nuisance + prior[:, None, :] * np.eye(nuisance.shape[2])
    left = wanted - nuisance @ np.linalg.solve(inner, cross @ wanted)
    information = np.einsum("brp,brq->pq", left, wanted)
    covariance = np.linalg.inv(information)
    return Fit(
        parameters,
        np.einsum("pq,brq->pbr", covariance, left),
        np.sqrt(np.diag(covariance)),
    )


def _measured(trial: Trial, launches: Launches) -> Measured:
    """Return a function from a ball (and launch states) to its (B, R) weighted measurements."""
    states, durations = launches.states[:SHOTS], launches.durations[:SHOTS]
    times = durations[:, None] * np.linspace(0.0, 1.0, SAMPLES)
    density = durations[:, None] / trial.cameras.interval / SAMPLES
    weight = np.sqrt(density) * _comparable(trial.simulator, states, times)
    sigma = _label_error(trial, states)

    def measured(ball: Simulator | IndependentBall, first: Floats = states) -> Floats:
        paths = ball.fly(first, times).states
        rows = [paths[..., POSITION] / trial.cameras.position_noise]
        if trial.spin_labels == "per_row":
            rows.append(paths[..., SPIN] / sigma[:, None, None])
        stacked = np.concatenate(rows, axis=2) * weight[..., None]
        weighted: Floats = stacked.reshape(len(states), -1)
        return weighted

    return measured


def _comparable(simulator: Simulator, states: Floats, times: Floats) -> NDArray[np.bool_]:
    """Return which of (B, T) samples can be compared: far from a bounce, where spins jump.

    And none of a shot that bounces near the table's border, which it may miss in the other world.
    """
    contacts = simulator.fly(states, times[:, -1:] + NEAR_BOUNCE).contacts
    apart = np.abs(times[:, :, None] - contacts.time[:, None, :]) >= NEAR_BOUNCE
    outside = np.abs(contacts.before[..., :2]) > WELL_INSIDE
    comparable: NDArray[np.bool_] = np.all(apart | np.isnan(contacts.time)[:, None, :], axis=2)
    comparable[outside.any(axis=(1, 2))] = False
    return comparable


def _label_error(trial: Trial, states: Floats) -> Floats:
    """Return (B,) standard deviations of a label's components in rad/s."""
    error: Floats = trial.cameras.spin_noise * np.linalg.norm(states[:, SPIN], axis=1) + LEAST_ERROR
    return error


def _fitted(trial: Trial) -> tuple[tuple[str, str], ...]:
    """Return the own parameters of the nominal simulator and the hidden ones, sensor aside."""
    own = {(e, p) for e, values in trial.nominal.effects.items() for p in values}
    hidden = {(cause.effect, cause.parameter) for cause in trial.hidden}
    ours = (e for e in own | hidden if catalogue()[e[0]].acts != "sensor" and e[0] not in NOT_OURS)
    return tuple(sorted(ours))


def _slope(measured: Measured, simulator: Simulator, name: tuple[str, str]) -> Floats:
    effect, parameter = name
    low, high = next(p.bounds for p in catalogue()[effect].parameters if p.name == parameter)
    value, step = simulator.effects[effect][parameter], PARAMETER_STEP * (high - low)
    a, b = max(value - step, low), min(value + step, high)
    above = measured(simulator.amended(effect, **{parameter: b}))
    slope: Floats = (above - measured(simulator.amended(effect, **{parameter: a}))) / (b - a)
    return slope


def _nuisance(trial: Trial, states: Floats, measured: Measured) -> tuple[Floats, Floats]:
    """Return (B, R, 11) slopes by launch state and bounce scatter, and (B, 11) prior weights.

    One bounce that deviates by a share is one whose restitution or friction is off by it.
    """
    simulator = trial.simulator
    columns = []
    for i, step in enumerate(STATE_STEPS):
        shift = step * np.eye(9)[i]
        above, below = measured(simulator, states + shift), measured(simulator, states - shift)
        columns.append((above - below) / (2 * step))
    for name, share in (
        ("restitution", trial.scatter.restitution),
        ("friction", trial.scatter.friction),
    ):
        size = share * simulator.effects["table_bounce"][name]
        columns.append(size * _slope(measured, simulator, ("table_bounce", name)))
    prior = np.zeros((len(states), len(columns)))
    prior[:, :6] = UNKNOWN_LAUNCH**-2
    prior[:, 9:] = 1.0
    prior[:, SPIN] = _label_weight(trial, states)[:, None]
    return np.stack(columns, axis=2), prior


def _label_weight(trial: Trial, states: Floats) -> Floats:
    """Return the (B,) weight of what is known of a launch's spin beside the rows."""
    if trial.spin_labels == "per_shot":
        weight: Floats = _label_error(trial, states) ** -2
        return weight
    return np.full(len(states), UNLABELLED_SPIN**-2)
