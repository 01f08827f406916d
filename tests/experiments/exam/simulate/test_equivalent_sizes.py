"""Equivalent sizes, against a full nonlinear fit of the catalogue's form."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from experiments.exam.simulate.equivalent_sizes import best_fit, equivalent_physics
from experiments.exam.simulate.independent_ball import IndependentBall
from experiments.exam.simulate.laws import FORMS
from rallygap.models.gap.hypotheses import Hypothesis
from tests.experiments.exam.example_trials import NO_SCATTER, NOMINAL, drawn, trial

SIZES = {
    "speed_dependent_drag": ("c", -0.03),
    "spin_dependent_drag": ("c", 0.03),
    "lift_saturation": ("kappa", 0.3),
    "lift_crisis": ("d", 0.6),
    "spin_decay": ("c", 0.01),
    "wind": ("y", 0.1),
    "side_force": ("cy", 0.01),
    "speed_dependent_restitution": ("c", 0.02),
    "spin_dependent_restitution": ("c", 0.004),
    "slip_dependent_friction": ("c", 0.006),
    "tangential_elasticity": ("et", 0.1),
}


def hidden(effect, **settings):
    parameter, size = SIZES[effect]
    return trial(causes={effect: {parameter: size}}, dynamics="independent", **settings)


def fitted(asked, launches, effect, physics):
    """A full nonlinear fit of launch states, own parameters and the effect, without scatter."""
    parameters, _, _ = best_fit(asked, launches)
    count = len(launches.states)
    times = launches.durations[:, None] * np.linspace(0.01, 0.99, 60)
    bounces = NOMINAL.fly(launches.states, times).contacts.time[:, None, :2]
    weight = np.sqrt(launches.durations)[:, None, None] * np.ones((count, 60, 6))
    weight *= ~(np.abs(times[..., None] - bounces) < 0.004).any(axis=2, keepdims=True)
    weight[..., :3] /= 0.003
    weight[..., 3:] /= 0.05 * np.linalg.norm(launches.states[:, 6:], axis=1)[:, None, None] + 1
    columns = [0, 1, 2, 6, 7, 8]
    data = IndependentBall(physics).fly(launches.states, times).states[..., columns]
    scale = np.array([1e-3] * 3 + [1e-2] * 3 + [1.0] * 3)
    start = asked.simulator

    def misses(x):
        simulator = start
        for parameter, step in zip(parameters, x[: len(parameters)], strict=True):
            simulator = parameter.at(simulator, parameter.value(start) + 1e-3 * step)
        states = launches.states + scale * x[len(parameters) :].reshape(count, 9)
        return (weight * (simulator.fly(states, times).states[..., columns] - data)).ravel()

    found = least_squares(misses, np.zeros(len(parameters) + 9 * count), max_nfev=4).x
    step = 1e-3 * found[parameters.index(Hypothesis(effect, SIZES[effect][0]))]
    return SIZES[effect][1] + step


@pytest.mark.parametrize("effect", FORMS)
def test_a_full_fit_finds_the_stated_size_and_forms_are_near_the_catalogue(effect):
    asked, launches = hidden(effect, scatter=NO_SCATTER), drawn(12, seed=2)
    physics = equivalent_physics(asked, launches)
    assert fitted(asked, launches, effect, physics) == pytest.approx(SIZES[effect][1], rel=0.03)
    found = equivalent_physics(hidden(effect), drawn(60))
    name = f"{effect}_{SIZES[effect][0]}"
    assert getattr(found, name) == pytest.approx(SIZES[effect][1], rel=0.5)
    assert found.gravity_g == pytest.approx(9.81, abs=0.02)


def test_bounce_scatter_makes_the_table_less_certain():
    launches, asked = drawn(60), hidden("speed_dependent_restitution")
    parameters, _, certain = best_fit(replace(asked, scatter=NO_SCATTER), launches)
    _, _, scattered = best_fit(asked, launches)
    e = parameters.index(Hypothesis("table_bounce", "restitution"))
    assert scattered[e] > 2 * certain[e]
