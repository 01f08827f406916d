"""The truth: hidden, different from every shipped simulator, and possible."""

import numpy as np
import pytest

from rallygap.models.arena.truth import draw_truth
from rallygap.models.ball.simulators import shipped, shipped_names
from tests.models.arena.sessions import flying
from tests.models.ball.balls import energy

SEEDS = range(15)


def test_it_differs_from_every_shipped_simulator_in_several_effects():
    for seed in SEEDS:
        hidden = draw_truth(seed).simulator.to_dict()
        for known in (shipped(name).to_dict() for name in shipped_names()):
            wrong = [effect for effect in known if hidden[effect] != known[effect]]
            assert len(set(hidden) - set(known)) >= 5
            assert len(wrong) >= 3


def test_arenas_of_different_seeds_have_different_fields_of_similar_size():
    fields = [draw_truth(seed).camera_field for seed in SEEDS]

    assert len({field.seed for field in fields}) == len(fields)
    assert [f.standard_deviation for f in fields] == pytest.approx([0.0015] * 15, rel=0.2)
    assert [f.length for f in fields] == pytest.approx([0.8] * 15, rel=0.2)


def test_a_shipped_simulator_can_fly_the_balls():
    drawn, given = draw_truth(3), draw_truth(3, "ground_truth")
    net = drawn.simulator.to_dict()["net"]
    assert given.simulator.to_dict() == {"net": net, **shipped("ground_truth").to_dict()}
    assert (given.camera_field, given.scatter) == (drawn.camera_field, drawn.scatter)


def test_no_effect_that_is_hidden_is_negligible():
    flat = np.array([[0.0, 1.3, 0.3, 0.5, -9.0, 1.0, 150.0, 50.0, 80.0]])
    for seed in SEEDS:
        simulator = draw_truth(seed).simulator
        end = simulator.fly(flat, [0.6]).states[0, 0, :3]
        for name in ("speed_dependent_drag", "lift_saturation", "wind", "table_tilt"):
            without = {key: values for key, values in simulator.effects.items() if key != name}
            other = type(simulator)(without).fly(flat, [0.6]).states[0, 0, :3]
            assert np.linalg.norm(other - end) > 0.001, name


@pytest.mark.parametrize("seed", [0, 1])
def test_no_bounce_gains_energy_at_any_speed(seed):
    states = flying(2000, np.random.default_rng(seed))

    contacts = draw_truth(seed).simulator.fly(states, [0.0, 0.05]).contacts

    met = contacts.count > 0
    assert met.sum() > 1500
    before, after = contacts.before[met, 0], contacts.after[met, 0]
    assert (energy(after) <= energy(before) * (1 + 1e-12)).all()
