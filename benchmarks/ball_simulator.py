"""The ball simulator beside its peers: same physics, same shots, same run (`make bench`).

Peers: a roll-out vectorised over shots in numpy (the same Runge-Kutta step, contacts located
on the step) and scipy's DOP853 with events at 1e-12, which is also the yardstick for
everybody's error.
"""

import time
import timeit
from collections.abc import Callable

import numpy as np
from rich.console import Console
from rich.table import Table

from models.ball.simulator import Simulator
from models.ball.state import BALL_RADIUS, DRAG_FACTOR, MAGNUS_FACTOR
from tests.models.ball.reference import Physics

SHOT = 0.8  # s
TIMES = np.arange(1, 161) * 0.005
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
    """Rally balls that bounce on the table, from slow lobs to 20 m/s."""
    generator = np.random.default_rng(3)
    ball = np.empty((count, 9))
    ball[:, :3] = generator.uniform([-0.3, 0.9, 0.15], [0.3, 1.3, 0.4], (count, 3))
    ball[:, 3] = generator.uniform(-0.5, 0.5, count)
    ball[:, 4] = -generator.uniform(3, 20, count)
    ball[:, 5] = ball[:, 2] / (ball[:, 1] + 0.6) * ball[:, 4] + 1.5
    ball[:, 6:] = generator.normal(0, 200, (count, 3))
    return ball


def derivative(s: np.ndarray) -> np.ndarray:
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
    _, _, _, vx, vy, vz, wx, wy, _ = s
    slip = np.stack([vx - BALL_RADIUS * wy, vy + BALL_RADIUS * wx])
    grip = FRICTION * (1 + RESTITUTION) * np.abs(vz) / np.hypot(*slip)
    alpha = np.minimum(grip, 0.4)
    after = s.copy()
    after[3:5] -= alpha * slip
    after[5] *= -RESTITUTION
    after[6:8] += 1.5 * alpha / BALL_RADIUS * np.stack([-slip[1], slip[0]])
    return after


def located(s: np.ndarray, h: np.ndarray) -> np.ndarray:
    """Time of the touch inside a step: Newton with the vertical velocity, kept by bisection."""
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
    """Structure of arrays: a row a component, the fastest layout for numpy."""
    states, state = np.empty((len(TIMES), 9, len(balls))), np.ascontiguousarray(balls.T)
    for k in range(len(TIMES)):
        h = np.full(len(balls), 0.005)
        ahead = runge_kutta(state, h)
        while (hit := np.flatnonzero((ahead[2] < BALL_RADIUS) & (ahead[5] < 0))).size:
            moment = located(state[:, hit], h[hit])
            state = state.copy()
            state[:, hit] = bounce(runge_kutta(state[:, hit], moment))
            h[hit] -= moment
            ahead[:, hit] = runge_kutta(state[:, hit], h[hit])
        states[k] = state = ahead
    return states.transpose(2, 0, 1)


def with_rallygap(balls: np.ndarray) -> np.ndarray:
    return SIMULATOR.fly(balls, TIMES).states


def with_scipy(balls: np.ndarray) -> np.ndarray:
    physics = Physics(G, CD, CM, RESTITUTION, FRICTION)
    return np.stack([physics.fly(ball, TIMES)[0] for ball in balls])


def rate(roll: Callable[[np.ndarray], np.ndarray], count: int, repeats: int) -> float:
    """Best shots a second over the repeats, in batches of at most a thousand."""
    balls = shots(count)
    roll(balls[:2])
    best = np.inf
    for _ in range(repeats):
        start = time.perf_counter()
        for batch in np.array_split(balls, max(1, count // 1000)):
            roll(batch)
        best = min(best, time.perf_counter() - start)
    return count / best


def error(roll: Callable[[np.ndarray], np.ndarray], balls: np.ndarray, true: np.ndarray) -> float:
    """Greatest distance (m) from the yardstick while the ball is over the table."""
    over = np.logical_and.accumulate(
        (np.abs(true[..., 1]) < 1.32) & (np.abs(true[..., 0]) < 0.71), axis=1
    )
    distance = np.linalg.norm(roll(balls)[..., :3] - true[..., :3], axis=-1)
    return float(distance[over].max())


def main() -> None:
    """Print shots a second, the ratio to rallygap and the error of each."""
    balls = shots(40)
    true = with_scipy(balls)
    rows = [
        ("rallygap, one core", rate(with_rallygap, 20_000, 5), error(with_rallygap, balls, true)),
        ("numpy, vectorised", rate(with_numpy, 2_000, 3), error(with_numpy, balls, true)),
        ("scipy DOP853, 1e-12", rate(with_scipy, 20, 1), 0.0),
    ]
    table = Table("roll-out", "shots/s", "rallygap is", "greatest error over the table (m)")
    for name, speed, distance in rows:
        ratio = f"{rows[0][1] / speed:,.1f} x"
        table.add_row(name, f"{speed:,.0f}", ratio, f"{distance:.1e}" if distance else "yardstick")
    console = Console()
    console.print(f"{SHOT} s a shot at 200 Hz, table contacts located, nominal model")
    console.print(table)
    each = min(timeit.repeat(lambda: SIMULATOR.fly(balls[0], TIMES[:60]), number=100, repeat=20))
    console.print(f"one shot of 0.3 s, called alone: {each * 1e4:.0f} µs")


if __name__ == "__main__":
    main()
