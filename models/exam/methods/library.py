"""The library: by how much every effect of the catalogue changes what is measured next.

Where the *measured* state is ``s``, an effect of size theta changes what is measured next, be it an
acceleration or a state after a bounce, by

    F = d next / d theta - (d next / d s) (d s / d theta).

The second part is that of sensor effects: the true state is not the measured one. All comes from
differences of exact flights between few moments, so that new effects need no code.
"""

from dataclasses import dataclass

import numpy as np

from models.ball.simulator import Simulator
from models.ball.state import SPIN
from models.ball.types import Floats
from models.gap.fit.measurement import (
    Prediction,
    Schedule,
    hypothesis_derivatives,
    nuisance_derivatives,
    predict_measurements,
)
from models.gap.hypotheses import Hypothesis

STENCIL = 2e-3  # s between moments of which differences are taken


@dataclass(frozen=True)
class Library:
    """The library at M measured states.

    Attributes:
        terms: (M, D, K) by how much each of K effects changes what is measured next.
        expected: (M, D) what the simulator says of it.
        by_spin: (M, D, 3) how that depends on the measured spin.
        contacts: (M, C) s from now when balls meet something, NaN where they do not.
    """

    terms: Floats
    expected: Floats
    by_spin: Floats
    contacts: Floats


def library(
    simulator: Simulator, states: Floats, ahead: float, columns: tuple[Hypothesis, ...]
) -> Library:
    """Return the library at (M, 9) states, about states some time ahead or accelerations.

    Args:
        simulator: nominal, without sensor effects.
        states: where.
        ahead: s to the D = 9 components of the states that are measured next; if zero these are the
            D = 6 rates of change of velocity and spin.
        columns: the K effects.
    """
    moments = _moments(len(states), ahead)
    view = predict_measurements(simulator, moments, states)
    now, later = _measured(hypothesis_derivatives(simulator, moments, states, view, columns))
    by_now, by_later = _measured(nuisance_derivatives(simulator, moments, states, view))
    slopes = by_later @ np.linalg.inv(by_now)
    contacts = np.where(view.smooth_until[:, None] >= 0.0, np.nan, view.contacts)
    return Library(later - slopes @ now, _measured(view)[1], slopes[:, :, SPIN], contacts)


def rates(simulator: Simulator, states: Floats) -> Floats:
    """Return the (M, 6) rates of change of velocity and spin at (M, 9) states."""
    return _measured(predict_measurements(simulator, _moments(len(states), 0.0), states))[1]


def _moments(count: int, ahead: float) -> Schedule:
    """Return moments about now, and about a later one if there is one."""
    now = np.array([-STENCIL, 0.0, STENCIL])
    times = np.concatenate([now, ahead + now]) if ahead else now
    places = np.tile(np.arange(len(times)), (count, 1))
    return Schedule(np.tile(times, (count, 1)), places, places)


def _measured(view: Prediction) -> tuple[Floats, Floats]:
    """Return (M, 9, ...) the state now, and that later or else (M, 6, ...) rates of v and w."""
    p, w = view.positions, view.labels
    speeds = (p[:, 2::3] - p[:, 0::3]) / (2 * STENCIL)
    states = np.concatenate([p[:, 1::3], speeds, w[:, 1::3]], axis=2)
    if states.shape[1] > 1:
        return states[:, 0], states[:, 1]
    faster = (p[:, 2] - 2 * p[:, 1] + p[:, 0]) / STENCIL**2
    drift = (w[:, 2] - w[:, 0]) / (2 * STENCIL)
    return states[:, 0], np.concatenate([faster, drift], axis=1)
