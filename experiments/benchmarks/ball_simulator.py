"""Speed and error of the ball simulator, compared with numpy and scipy.

The peers simulate the same physics and the same shots: a simulation vectorised over shots in numpy
(the same Runge-Kutta step, contacts located inside a step), and scipy's DOP853 with events at a
tolerance of 1e-12, from which the errors of both are measured.
"""

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from experiments.benchmarks.comparison import faster, one_core, rate, report
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import BALL_RADIUS, DRAG_FACTOR, MAGNUS_FACTOR

TIMES = np.arange(1, 161) * 0.005  # 0.8 s at 200 Hz
G, CD, CM, RESTITUTION, FRICTION = 9.81, 0.55, 0.069, 0.93, 0.25
SIMULATOR = Simulator.from_dict(
    {
        "gravity": {"g": G},
        "drag": {"cd": CD},
        "magnus": {"cm": CM},
        "table_bounce": {"restitution": RESTITUTION, "friction": FRICTION},
    }
)


def shots(count: int) -> np.ndarray:
    """Return (N, 9) initial states of shots that bounce on the table, at 3 to 20 m/s."""
    generator = np.random.default_rng(3)
    ball = np.empty((count, 9))
    ball[:, :3] = generator.uniform([-0.3, 0.9, 0.15], [0.3, 1.3, 0.4], (count, 3))
    ball[:, 3] = generator.uniform(-0.5, 0.5, count)
    ball[:, 4] = -generator.uniform(3, 20, count)
    ball[:, 5] = ball[:, 2] / (ball[:, 1] + 0.6) * ball[:, 4] + 1.5
    ball[:, 6:] = generator.normal(0, 200, (count, 3))
    return ball


def derivative(s: np.ndarray) -> np.ndarray:
    """Return the (9, ...) time derivative of states: gravity, drag and Magnus force."""
    _, _, _, vx, vy, vz, wx, wy, wz = s
    drag = DRAG_FACTOR * CD * np.sqrt(vx * vx + vy * vy + vz * vz)
    lift = MAGNUS_FACTOR * CM
    slope = np.zeros_like(s)
    slope[:3] = s[3:6]
    slope[3] = lift * (wy * vz - wz * vy) - drag * vx
    slope[4] = lift * (wz * vx - wx * vz) - drag * vy
    slope[5] = lift * (wx * vy - wy * vx) - drag * vz - G
    return slope


def runge_kutta(s: np.ndarray, h: np.ndarray) -> np.ndarray:
    k1 = derivative(s)
    k2 = derivative(s + h / 2 * k1)
    k3 = derivative(s + h / 2 * k2)
    k4 = derivative(s + h * k3)
    return s + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def bounce(s: np.ndarray) -> np.ndarray:
    """Return (9, ...) states after a table contact with restitution and friction."""
    _, _, _, vx, vy, vz, wx, wy, _ = s
    slip = np.stack([vx - BALL_RADIUS * wy, vy + BALL_RADIUS * wx])
    grip = FRICTION * (1 + RESTITUTION) * np.abs(vz) / np.hypot(*slip)
    alpha = np.minimum(grip, 0.4)
    after = s.copy()
    after[3:5] -= alpha * slip
    after[5] *= -RESTITUTION
    after[6:8] += 1.5 * alpha / BALL_RADIUS * np.stack([-slip[1], slip[0]])
    return after


def contact_times(s: np.ndarray, h: np.ndarray) -> np.ndarray:
    """Return the times of contacts inside a step, by Newton steps within a bisection."""
    low, high, moment = np.zeros_like(h), h.copy(), h.copy()
    for _ in range(8):
        there = runge_kutta(s, moment)
        gap, speed = there[2] - BALL_RADIUS, there[5]
        high, low = np.where(gap < 0, moment, high), np.where(gap < 0, low, moment)
        guess = moment - gap / np.where(speed < 0, speed, -np.inf)
        moment = np.where((guess > low) & (guess < high), guess, (low + high) / 2)
        if np.abs(gap).max() < 1e-13:
            break
    return moment


def with_numpy(balls: np.ndarray) -> np.ndarray:
    """Return (N, T, 9) states, simulated with one array per component."""
    states, state = np.empty((len(TIMES), 9, len(balls))), np.ascontiguousarray(balls.T)
    for k in range(len(TIMES)):
        h = np.full(len(balls), 0.005)
        ahead = runge_kutta(state, h)
        while (hit := np.flatnonzero((ahead[2] < BALL_RADIUS) & (ahead[5] < 0))).size:
            moment = contact_times(state[:, hit], h[hit])
            state = state.copy()
            state[:, hit] = bounce(runge_kutta(state[:, hit], moment))
            h[hit] -= moment
            ahead[:, hit] = runge_kutta(state[:, hit], h[hit])
        states[k] = state = ahead
    return states.transpose(2, 0, 1)


def with_scipy(state: np.ndarray) -> np.ndarray:
    """Return (T, 9) states of one ball, by DOP853 with contacts as events."""

    def slope(_time: float, s: np.ndarray) -> np.ndarray:
        return derivative(s)

    def touch(_time: float, s: np.ndarray) -> float:
        return s[2] - BALL_RADIUS

    event: Any = touch
    event.terminal, event.direction = True, -1
    states: list[np.ndarray] = []
    ahead, now = TIMES, 0.0
    while len(ahead):
        span = (now, ahead[-1])
        solution: Any = solve_ivp(
            slope, span, state, "DOP853", ahead, events=event, rtol=1e-12, atol=1e-12
        )
        states.extend(solution.y.T)
        if solution.status == 0:
            break
        now, state = solution.t_events[0][0], bounce(solution.y_events[0][0])
        ahead = TIMES[now < TIMES]
    return np.array(states)


def error(states: np.ndarray, true: np.ndarray) -> float:
    """Return the largest position error (m) while the ball is above the table."""
    over = np.logical_and.accumulate(
        (np.abs(true[..., 1]) < 1.32) & (np.abs(true[..., 0]) < 0.71), axis=1
    )
    distance = np.linalg.norm(states[..., :3] - true[..., :3], axis=-1)
    return float(distance[over].max())


def main() -> None:
    """Measure shots per second and errors."""
    initial, few, many = shots(40), shots(5), shots(1000)
    true = np.stack([with_scipy(ball) for ball in initial])
    with one_core():
        ours = rate(lambda: len(SIMULATOR.fly(many, TIMES).states))
        peers = {
            "numpy, vectorised": rate(lambda: len(with_numpy(many))),
            "scipy DOP853, tolerance 1e-12": rate(lambda: len([with_scipy(ball) for ball in few])),
        }
        calls = rate(lambda: len(SIMULATOR.fly(few[0], TIMES[:60]).states))
    report(
        "ball_simulator",
        [faster("shots of 0.8 s at 200 Hz per second", ours, *peer) for peer in peers.items()],
        largest_error_m=error(SIMULATOR.fly(initial, TIMES).states, true),
        largest_error_of_numpy_m=error(with_numpy(initial), true),
        one_shot_of_300_ms_us=1e6 / calls,
    )


if __name__ == "__main__":
    main()
