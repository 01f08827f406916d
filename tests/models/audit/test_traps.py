"""Traps are named where an engine has them, and nowhere else."""

import numpy as np
import pytest

from rallygap.models.audit.audit import audit
from rallygap.models.audit.traps import traps
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.simulators import shipped
from rallygap.models.engines.engine import EffectsEngine, FunctionEngine
from tests.models.audit.closed_forms import SOLID, bouncing

TABLE = {"table_bounce": {"restitution": 0.92, "friction": 0.25}}
AIR = {"gravity": {"g": 9.81}, "drag": {"cd": 0.47}}


def found(engine):
    return {one.identifier: one for one in traps(audit(engine))}


def of_list(**effects):
    return found(EffectsEngine("mine", Simulator.from_dict({**AIR, **effects})))


def test_the_literature_has_none():
    assert found(EffectsEngine("literature", shipped("literature"))) == {}


@pytest.mark.parametrize(
    ("cm", "trap"), [(-0.43, "inverse_lift"), (0.5, "large_lift"), (0.0, "no_lift")]
)
def test_a_wrong_lift_is_named_with_its_cost(cm, trap):
    named = of_list(**TABLE, magnus={"cm": cm})
    assert list(named) == [trap]
    assert named[trap].cost_mm == pytest.approx(940.0 * abs(cm - 0.069), rel=0.1)


def test_a_ball_without_a_table_does_not_bounce():
    assert set(of_list(magnus={"cm": 0.07})) == {"no_table"}


def test_a_table_that_keeps_balls_has_a_dead_contact():
    dead = {"table_bounce": {"restitution": 0.02, "friction": 0.25}, "magnus": {"cm": 0.07}}
    assert set(of_list(**dead)) == {"dead_contact"}


def test_an_engine_that_cuts_spins():
    simulator = shipped("literature")

    def cutting(states, times):
        sizes = np.linalg.norm(states[:, 6:], axis=1, keepdims=True)
        states[:, 6:] *= np.minimum(1.0, 100.0 / np.maximum(sizes, 1e-9))
        return simulator.fly(states, times).states

    assert "at 100 rad/s" in found(FunctionEngine("mine", cutting))["spin_limit"].sentence


def test_a_solid_sphere_in_a_vacuum():
    named = found(bouncing())
    assert set(named) == {"no_drag", "no_lift", "solid_sphere"}
    assert "2/7" in named["solid_sphere"].sentence


def test_a_ball_that_never_rolls():
    assert set(found(bouncing(cap=0.15))) == {"no_drag", "no_lift", "never_rolls"}


def test_a_restitution_that_depends_on_the_phase_of_the_contact_scatters():
    def by_phase(ball):
        return 0.85 + 0.1 * np.sin(1e5 * ball[2])

    named = found(bouncing(cap=2 / 5, restitution=by_phase))
    assert "between 0.7" in named["restitution_scatters"].sentence
    assert SOLID < 2 / 5
