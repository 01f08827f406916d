"""Structure by place: an effect of flight that differs between the two sides of the net.

To first order such a difference changes a path as a force does that has one sign on one side and
the other sign on the other. With the causes in the simulator, a score test of its size is made for
each parameter of the flight that the simulator lists or that is a cause. A difference by place is
no constant that a simulator could have, so nothing is amended.
"""

from collections.abc import Sequence

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, STATE_SIZE
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.refit import RefitResult
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.inference.score_test import Evidence, ScoreTest
from rallygap.models.gap.locate.propagation import after_forcing
from rallygap.models.gap.locate.term_library import evidence_with
from rallygap.models.gap.locate.terms import Flown, Term, Terms
from rallygap.models.gap.settings import GapSettings

BY_SIDE = "by_side"  # effect of these terms
MOMENT = 1e-3  # s, over which a change of velocity gives a force


def side_tests(
    fit: RefitResult, given: Sequence[Hypothesis], settings: GapSettings
) -> dict[Hypothesis, ScoreTest]:
    """Test the differences between sides of the parameters of flight among those given.

    Args:
        fit: shots about the simulator with the causes.
        given: the parameters that are free.
        settings: of the workflow.

    Returns:
        The tests of those that the shots decide; a size is that at y > 0 less that at y < 0.
    """
    in_flight = tuple(one for one in given if one.phase == "flight")
    if not in_flight:
        return {}
    terms = _terms(Flown.of(fit.linear), in_flight)
    _, evidence = evidence_with(terms, fit, fit.noise_estimate.noise, settings)
    places = {column: k for k, column in enumerate(evidence.columns)}
    free = [places[one] for one in given]
    tests = {
        one: evidence.score_test([places[term]], free)
        for one, term in zip(in_flight, terms.terms, strict=True)
    }
    return {one: test for one, test in tests.items() if _decides(evidence, test)}


def _decides(evidence: Evidence, test: ScoreTest) -> bool:
    (k,), settings = test.block, evidence.settings.name
    enough = test.effective_sample_size > settings.min_sample_size
    left = test.information[0, 0] > settings.min_term_information * evidence.total[k, k]
    return bool(left and enough)


def _terms(flown: Flown, parameters: Sequence[Hypothesis]) -> Terms:
    """Return a difference of one unit between the sides, for each parameter."""
    side = np.where(flown.states[..., POSITION.start + 1] > 0.0, 0.5, -0.5)[..., None]
    forcings = [side * _forcing(flown, one) for one in parameters]
    changes = after_forcing(flown.arcs, np.stack(forcings, axis=-1))
    names = [Term(BY_SIDE, one.identity) for one in parameters]
    return flown.measured_changes(names, changes).where_used(flown.linear)


def _forcing(flown: Flown, parameter: Hypothesis) -> Floats:
    """Return what a unit of a parameter does to the rates of change of (B, T, 9) states."""
    simulator = flown.linear.simulator.without_surfaces()
    value, near = parameter.value(simulator), parameter.nearby(simulator)
    changed = _moment_later(parameter.at(simulator, near), flown.states)
    forcing = (changed - _moment_later(simulator, flown.states)) / (MOMENT * (near - value))
    forcing[..., POSITION] = 0.0  # of the second order
    return forcing


def _moment_later(simulator: Simulator, states: Floats) -> Floats:
    later = simulator.fly(states.reshape(-1, STATE_SIZE), np.array([0.0, MOMENT])).states[:, 1]
    return later.reshape(states.shape)
