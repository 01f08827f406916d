"""The library of regression terms: how every parameter of the catalogue changes measurements.

At a *measured* state ``s``, a parameter theta changes the next measurement, an acceleration or a
state after a bounce, by

    F = d next / d theta - (d next / d s) (d s / d theta).

The second term is that of sensor effects, for which the true state is not the measured one. All
derivatives are finite differences of roll-outs, so new effects need no code.
"""

from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import SPIN
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.measurement import (
    Prediction,
    Schedule,
    hypothesis_derivatives,
    nuisance_derivatives,
    predict_measurements,
)
from rallygap.models.gap.hypotheses import Hypothesis

STENCIL = 2e-3  # s between the times of finite differences


@dataclass(frozen=True)
class Library:
    """The library at M measured states."""

    terms: Floats  # (M, D, K) derivatives of the next measurement by K parameters
    expected: Floats  # (M, D) next measurement by the simulator
    by_spin: Floats  # (M, D, 3) its derivatives by the measured spin
    contacts: Floats  # (M, C) s from now to contacts, NaN where there are fewer


def library(
    simulator: Simulator, states: Floats, ahead: float, columns: tuple[Hypothesis, ...]
) -> Library:
    """Return the library at (M, 9) states, for later states or for accelerations.

    Args:
        simulator: nominal, without sensor effects.
        states: measured.
        ahead: s to the next measured states (D = 9 components); zero for the rates of change of
            velocity and spin (D = 6).
        columns: the K parameters.
    """
    schedule = _schedule(len(states), ahead)
    prediction = predict_measurements(simulator, schedule, states)
    by_hypotheses = hypothesis_derivatives(simulator, schedule, states, prediction, columns)
    now, later = _measured(by_hypotheses)
    by_now, by_later = _measured(nuisance_derivatives(simulator, schedule, states, prediction))
    slopes = by_later @ np.linalg.inv(by_now)
    contacts = np.where(prediction.smooth_until[:, None] >= 0.0, np.nan, prediction.contacts)
    return Library(later - slopes @ now, _measured(prediction)[1], slopes[:, :, SPIN], contacts)


def rates(simulator: Simulator, states: Floats) -> Floats:
    """Return the (M, 6) rates of change of velocity and spin at (M, 9) states."""
    return _measured(predict_measurements(simulator, _schedule(len(states), 0.0), states))[1]


def _schedule(count: int, ahead: float) -> Schedule:
    """Return the times of finite differences about now, and about ``ahead`` if it is not zero."""
    now = np.array([-STENCIL, 0.0, STENCIL])
    times = np.concatenate([now, ahead + now]) if ahead else now
    return Schedule.of_times(np.tile(times, (count, 1)))


def _measured(prediction: Prediction) -> tuple[Floats, Floats]:
    """Return (M, 9, ...) states now, and those later or (M, 6, ...) rates of velocity and spin."""
    p, w = prediction.positions, prediction.labels
    speeds = (p[:, 2::3] - p[:, 0::3]) / (2 * STENCIL)
    states = np.concatenate([p[:, 1::3], speeds, w[:, 1::3]], axis=2)
    if states.shape[1] > 1:
        return states[:, 0], states[:, 1]
    faster = (p[:, 2] - 2 * p[:, 1] + p[:, 0]) / STENCIL**2
    drift = (w[:, 2] - w[:, 0]) / (2 * STENCIL)
    return states[:, 0], np.concatenate([faster, drift], axis=1)
