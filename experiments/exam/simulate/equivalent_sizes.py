"""Equivalent sizes: the constants of independent dynamics that correspond to a trial's causes.

A fit of the catalogue's form to balls of the independent dynamics finds some size of it, and some
values of the simulator's own parameters. The equivalent constants are those for which this best
fit, weighted like the trial's measurements, finds the causes' sizes and leaves the simulator's own
parameters unchanged. The fit is linear in the small difference between both dynamics; launch
states and bounce scatter of each shot are nuisance parameters.
"""

from collections.abc import Callable

import numpy as np
from scipy.optimize import root

from experiments.exam.projection import projected_out
from experiments.exam.simulate.independent_ball import IndependentBall
from experiments.exam.simulate.laws import FORMS, Physics, physics_of
from experiments.exam.simulate.trial import Trial
from rallygap.models.audit.launches import Launches
from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, SPIN, TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.gap.hypotheses import OTHER_SURFACES, Hypothesis

SHOTS = 100  # in the fit
SAMPLES = 60  # a shot
NEAR_BOUNCE = 0.010  # s by which bounces of both dynamics may differ
WELL_INSIDE = np.array([TABLE_HALF_WIDTH, TABLE_HALF_LENGTH]) - 0.05  # m
MINIMUM_LABEL_ERROR = 1.0  # rad/s, also of the label of a ball without spin
STATE_STEPS = np.array([1e-4] * 3 + [1e-3] * 3 + [0.5] * 3)
PARAMETER_STEP = 1e-3  # of the parameter's bounds
LAUNCH_PRIOR = 10.0  # m and m/s, standard deviation: practically unknown
SPIN_PRIOR = 150.0  # rad/s, standard deviation of an unlabelled spin


Measure = Callable[..., Floats]  # from a ball, and launch states, to weighted measurements


def equivalent_physics(trial: Trial, launches: Launches) -> Physics:
    """Return the independent constants for which a best fit finds the trial's causes.

    Raises:
        RuntimeError: there are none, because these shots do not show the effect.
    """
    simulator = trial.simulator
    physics = physics_of(simulator)
    if not set(trial.causes) & set(FORMS):
        return physics
    measure = _measure(trial, launches)
    parameters, gain, errors = best_fit(trial, launches)
    names = [f"{parameter.effect}_{parameter.parameter}" for parameter in parameters]
    start = np.array([getattr(physics, name) for name in names])
    expected = measure(simulator)

    def constants(steps: Floats) -> Physics:
        return physics._replace(**dict(zip(names, start + steps * errors, strict=True)))

    def deviations(steps: Floats) -> Floats:
        residuals = measure(IndependentBall(constants(steps))) - expected
        return np.einsum("pbr,br->p", gain, residuals) / errors

    solution = root(deviations, np.zeros(len(names)), options={"xtol": 1e-4, "eps": 1e-4})
    if not np.abs(solution.fun).max() < 0.1:
        raise RuntimeError(f"{trial.name}: no independent dynamics correspond to its causes")
    return constants(solution.x)


def best_fit(trial: Trial, launches: Launches) -> tuple[tuple[Hypothesis, ...], Floats, Floats]:
    """Return the linear fit of hidden and own parameters about the simulator with the causes.

    Sensor effects and surfaces that no shot meets are left out.

    Returns:
        The P fitted parameters, the (P, B, R) gain from residuals to their changes, and their (P,)
        standard errors.
    """
    simulator, measure = trial.simulator, _measure(trial, launches)
    pairs = {
        (effect, name)
        for effects in (trial.base.effects, trial.causes)
        for effect, values in effects.items()
        for name in values
        if effect not in OTHER_SURFACES and catalogue()[effect].acts != "sensor"
    }
    parameters = tuple(Hypothesis(*pair) for pair in sorted(pairs))
    slopes = np.stack([_slope(measure, simulator, p) for p in parameters], axis=2)
    left = projected_out(slopes, *_nuisance(trial, launches.states[:SHOTS], measure))
    covariance = np.linalg.inv(np.einsum("brp,brq->pq", left, slopes))
    gain = np.einsum("pq,brq->pbr", covariance, left)
    return parameters, gain, np.sqrt(np.diag(covariance))


def _measure(trial: Trial, launches: Launches) -> Measure:
    """Return a function from a ball (and launch states) to its (B, R) weighted measurements.

    Left out are samples near a bounce, where spins jump, and shots that bounce near an edge, which
    may miss the table in the other dynamics.
    """
    states, durations = launches.states[:SHOTS], launches.durations[:SHOTS]
    times = durations[:, None] * np.linspace(0.0, 1.0, SAMPLES)
    contacts = trial.simulator.fly(states, times[:, -1:] + NEAR_BOUNCE).contacts
    apart = np.abs(times[:, :, None] - contacts.time[:, None, :]) >= NEAR_BOUNCE
    comparable: Bools = np.all(apart | np.isnan(contacts.time)[:, None, :], axis=2)
    comparable[(np.abs(contacts.before[..., :2]) > WELL_INSIDE).any(axis=(1, 2))] = False
    weight = np.sqrt(durations[:, None] / trial.cameras.interval / SAMPLES) * comparable
    sigma = _label_error(trial, states)

    def measure(ball: Simulator | IndependentBall, first: Floats = states) -> Floats:
        paths = ball.fly(first, times).states
        rows = [paths[..., POSITION] / trial.cameras.position_noise]
        if trial.spin_labels == "per_row":
            rows.append(paths[..., SPIN] / sigma[:, None, None])
        return (np.concatenate(rows, axis=2) * weight[..., None]).reshape(len(states), -1)

    return measure


def _label_error(trial: Trial, states: Floats) -> Floats:
    """Return (B,) standard deviations of a label's components in rad/s."""
    spins = np.linalg.norm(states[:, SPIN], axis=1)
    return trial.cameras.spin_noise * spins + MINIMUM_LABEL_ERROR


def _slope(measure: Measure, simulator: Simulator, parameter: Hypothesis) -> Floats:
    low, high = parameter.declaration.bounds
    value, step = parameter.value(simulator), PARAMETER_STEP * (high - low)
    a, b = max(value - step, low), min(value + step, high)
    above, below = measure(parameter.at(simulator, b)), measure(parameter.at(simulator, a))
    return (above - below) / (b - a)


def _nuisance(trial: Trial, states: Floats, measure: Measure) -> tuple[Floats, Floats]:
    """Return (B, R, 11) slopes by launch state and bounce scatter, and (B, 11) prior precisions.

    A bounce that deviates by a share is one whose restitution or friction differs by this share.
    """
    simulator = trial.simulator
    columns = []
    for i, step in enumerate(STATE_STEPS):
        shift = step * np.eye(9)[i]
        above, below = measure(simulator, states + shift), measure(simulator, states - shift)
        columns.append((above - below) / (2 * step))
    for name in ("restitution", "friction"):
        size = getattr(trial.scatter, name) * simulator.effects["table_bounce"][name]
        columns.append(size * _slope(measure, simulator, Hypothesis("table_bounce", name)))
    precision = np.zeros((len(states), len(columns)))
    precision[:, :6] = LAUNCH_PRIOR**-2
    precision[:, SPIN] = SPIN_PRIOR**-2
    if trial.spin_labels == "per_shot":
        precision[:, SPIN] = _label_error(trial, states)[:, None] ** -2
    precision[:, 9:] = 1.0
    return np.stack(columns, axis=2), precision
