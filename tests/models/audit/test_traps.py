"""Traps are named where an engine has them, and nowhere else."""

import numpy as np
import pytest

from rallygap.models.audit.audit import audit
from rallygap.models.audit.traps import traps
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.simulators import shipped
from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.engines.engine import EffectsEngine, FunctionEngine

TABLE = {"table_bounce": {"restitution": 0.92, "friction": 0.25}}
AIR = {"gravity": {"g": 9.81}, "drag": {"cd": 0.47}}
GRAVITY = 9.81
SOLID = 2 / 7


def fallen(ball, time):
    ball = ball.copy()
    ball[:3] += time * ball[3:6] - [0, 0, GRAVITY * time**2 / 2]
    ball[5] -= GRAVITY * time
    return ball


def at(ball, time, cap, friction, restitution):
    above, fall = ball[2] - BALL_RADIUS, -ball[5]
    contact = (np.sqrt(fall**2 + 2 * GRAVITY * above) - fall) / GRAVITY
    if time <= contact:
        return fallen(ball, time)
    before = fallen(ball, contact)
    slip = before[3:5] + BALL_RADIUS * np.array([-before[7], before[6]])
    impulse = friction * (1 + restitution) * -before[5] / max(np.linalg.norm(slip), 1e-9)
    change = -min(impulse, cap) * slip
    inertia = cap / (1 - cap)  # I / m r^2
    after = before.copy()
    after[3:5] += change
    after[5] *= -restitution
    after[6:8] += np.array([change[1], -change[0]]) / (inertia * BALL_RADIUS)
    return fallen(after, time - contact)


def bouncing(cap=SOLID, friction=0.3, restitution=lambda ball: 0.9):
    """A vacuum with one bounce that takes at most ``cap`` of the slip; restitution is by state."""

    def fly(states, times):
        return np.array(
            [[at(one, t, cap, friction, restitution(one)) for t in times] for one in states]
        )

    return FunctionEngine("closed form", fly)


def found(engine):
    """The traps by name; the fewest probes show them."""
    return {one.identifier: one for one in traps(audit(engine, patience=1e-9))}


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


@pytest.mark.parametrize(
    ("table", "trap"),
    [({}, "no_table"), ({"table_bounce": {"restitution": 0.02, "friction": 0.25}}, "dead_contact")],
)
def test_a_table_that_is_not_there_or_keeps_balls_is_named(table, trap):
    assert set(of_list(**table, magnus={"cm": 0.07})) == {trap}


def test_an_engine_that_cuts_spins():
    simulator = shipped("literature")

    def cutting(states, times):
        sizes = np.linalg.norm(states[:, 6:], axis=1, keepdims=True)
        states[:, 6:] *= np.minimum(1.0, 100.0 / np.maximum(sizes, 1e-9))
        return simulator.fly(states, times).states

    assert "at 100 rad/s" in found(FunctionEngine("mine", cutting))["spin_limit"].sentence


@pytest.mark.parametrize(
    ("cap", "trap", "says"),
    [(SOLID, "solid_sphere", "2/7"), (0.15, "never_rolls", "at most 38 % of the slip")],
)
def test_a_grip_that_is_not_that_of_a_shell_is_named(cap, trap, says):
    named = found(bouncing(cap=cap))
    assert set(named) == {"no_drag", "no_lift", trap}
    assert says in named[trap].sentence


def test_a_restitution_that_depends_on_the_phase_of_the_contact_scatters():
    def by_phase(ball):
        return 0.85 + 0.1 * np.sin(1e5 * ball[2])

    named = found(bouncing(cap=2 / 5, restitution=by_phase))
    assert "between 0.7" in named["restitution_scatters"].sentence
    assert SOLID < 2 / 5
