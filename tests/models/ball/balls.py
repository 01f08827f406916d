"""Balls for the tests: strategies and small simulators."""

import numpy as np
from hypothesis import strategies as st

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import BALL_MASS, BALL_RADIUS

INERTIA = 2 / 3 * BALL_MASS * BALL_RADIUS**2


def simulator(**effects):
    return Simulator.from_dict(effects)


NOMINAL = simulator(
    gravity={"g": 9.81},
    drag={"cd": 0.55},
    magnus={"cm": 0.069},
    table_bounce={"restitution": 0.93, "friction": 0.25},
)
NET_PLAY = NOMINAL.amended("net", restitution=0.2, friction=0.5)
RACKET = {"restitution": 0.878, "speed_loss": 0.02, "kp": 0.0019}


def vectors(limit):
    return st.tuples(*[st.floats(-limit, limit)] * 3).map(np.array)


@st.composite
def served_balls(draw, fastest=20.0, most_spin=600.0):
    """A ball over the far half of the table that flies towards -y."""
    position = [draw(st.floats(-0.5, 0.5)), draw(st.floats(0.8, 1.3)), draw(st.floats(0.1, 0.5))]
    velocity = [
        draw(st.floats(-1.5, 1.5)),
        -draw(st.floats(3.0, fastest)),
        draw(st.floats(-3.0, 3.0)),
    ]
    spin = draw(vectors(most_spin / np.sqrt(3)))
    return np.concatenate([position, velocity, spin])


def energy(states, g=0.0):
    """Kinetic, rotational and potential energy, J, of states (..., 9)."""
    v, w = states[..., 3:6], states[..., 6:9]
    motion = BALL_MASS / 2 * (v**2).sum(-1) + INERTIA / 2 * (w**2).sum(-1)
    return motion + BALL_MASS * g * states[..., 2]
