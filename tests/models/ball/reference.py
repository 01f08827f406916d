"""An independent ball: the same physics written again, in vectors, integrated by scipy.

It shares no code with ``models/ball`` and takes plain keyword arguments, so that an error in the
product can hardly hide in its oracle.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

MASS, RADIUS, DENSITY = 2.7e-3, 0.02, 1.2
DRAG = DENSITY * np.pi * RADIUS**2 / (2 * MASS)
LIFT = DENSITY * 4 / 3 * np.pi * RADIUS**3 / MASS


@dataclass(frozen=True)
class Physics:
    """The nominal model and a few effects, in the symbols of the literature.

    Coefficients of drag and lift may be functions of speed and spin ratio; ``other`` is a further
    acceleration by the velocity in the air.
    """

    gravity: Any = (0.0, 0.0, -9.81)
    cd: Any = 0.55
    cm: Any = 0.069
    restitution: float = 0.93
    friction: float = 0.25
    wind: tuple[float, float, float] = (0.0, 0.0, 0.0)
    spin_decay: float = 0.0
    other: Any = lambda u: 0.0 * u
    mass: float = 1.0

    def derivative(self, _time, state):
        velocity, spin = state[3:6], state[6:9]
        u = velocity - np.array(self.wind)
        speed = np.linalg.norm(u)
        ratio = RADIUS * np.linalg.norm(spin) / speed
        cd, cm = (c(speed, ratio) if callable(c) else c for c in (self.cd, self.cm))
        force = self.gravity - DRAG * cd * speed * u + LIFT * cm * np.cross(spin, u) + self.other(u)
        return np.concatenate([velocity, force / self.mass, -self.spin_decay * speed * spin])

    def bounce(self, state):
        """The matrices of Nakashima 2010 and 2011, as printed, for a level table."""
        v, w = state[3:6], state[6:9]
        slip = np.array([v[0] - RADIUS * w[1], v[1] + RADIUS * w[0]])
        alpha = self.friction * (1 + self.restitution) * abs(v[2]) / np.linalg.norm(slip)
        alpha = min(alpha, 0.4)
        a_v = np.diag([1 - alpha, 1 - alpha, -self.restitution])
        b_v = alpha * RADIUS * np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 0]])
        a_w = 3 * alpha / (2 * RADIUS) * np.array([[0, -1, 0], [1, 0, 0], [0, 0, 0]])
        b_w = np.diag([1 - 1.5 * alpha, 1 - 1.5 * alpha, 1])
        return np.concatenate([state[:3], a_v @ v + b_v @ w, a_w @ v + b_w @ w])

    def fly(self, state, times):
        """States at ``times`` and bounce times: DOP853 at 1e-12 with the touch as an event."""

        def touch(_time, y):
            return y[2] - RADIUS

        touch.terminal, touch.direction = True, -1
        states, bounces, now = [], [], 0.0
        state, times = np.array(state, dtype=float), np.asarray(times, dtype=float)
        while True:
            ahead = times[times > now]
            if not len(ahead):
                return np.array(states), bounces
            solution = solve_ivp(
                self.derivative,
                (now, ahead[-1]),
                state,
                method="DOP853",
                t_eval=ahead,
                events=touch,
                rtol=1e-12,
                atol=1e-12,
            )
            states.extend(solution.y.T)
            if solution.status == 0:
                return np.array(states), bounces
            now = float(solution.t_events[0][0])
            bounces.append(now)
            state = self.bounce(solution.y_events[0][0])
