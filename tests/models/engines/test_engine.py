"""Functions as engines: what is no flight is refused in one sentence."""

import numpy as np
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.models.engines.engine import (
    EffectsEngine,
    EngineError,
    FunctionEngine,
    check_deterministic,
)

SIMULATOR = shipped("literature")
BALLS = np.array([[0.1, 1.2, 0.3, 0.2, -6.0, 1.0, -100.0, 0.0, 20.0], [0.0, 1.0, 0.4, *[0.0] * 6]])
TIMES = 0.01 * np.arange(30)


def flown(states, times):
    return SIMULATOR.fly(states, times).states


def raises(states, times):
    raise RuntimeError("no licence")


@pytest.mark.parametrize(
    ("function", "problem"),
    [
        (raises, "mine raises RuntimeError: no licence"),
        (lambda states, times: flown(states, times)[:, 0], r"\(2, 9\); give \(2, 30, 9\)"),
        (lambda states, times: np.full((2, 30, 9), [np.nan]), "not finite, of ball 0"),
        (lambda states, times: "fast", "returns no numbers"),
        (lambda states, times: None, "the shape"),
    ],
)
def test_what_is_no_flight_is_refused(function, problem):
    with pytest.raises(EngineError, match=problem):
        FunctionEngine("mine", function).fly(BALLS, TIMES)


def test_a_function_flies_as_the_simulator_behind_it_and_cannot_change_its_caller_s_states():
    def careless(states, times):
        found = flown(states, times)
        states[:] = 0.0
        return found

    states = BALLS.copy()
    expected = EffectsEngine("literature", SIMULATOR).fly(BALLS, TIMES)
    np.testing.assert_array_equal(FunctionEngine("mine", careless).fly(states, TIMES), expected)
    np.testing.assert_array_equal(states, BALLS)


def test_an_engine_that_remembers_or_draws_is_noticed():
    random = np.random.default_rng(0)
    check_deterministic(EffectsEngine("literature", SIMULATOR), BALLS, TIMES)
    drawing = FunctionEngine(
        "mine", lambda states, times: flown(states, times) + 1e-6 * random.normal()
    )
    with pytest.raises(EngineError, match="other flights from the same states"):
        check_deterministic(drawing, BALLS, TIMES)
