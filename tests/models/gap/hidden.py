"""Simulated shots with a known cause in them."""

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.fit.measurement import Schedule, predict_measurements
from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.hypotheses import hypotheses
from rallygap.models.gap.settings import GapSettings

NOMINAL = Simulator.from_dict(
    {
        "gravity": {"g": 9.81},
        "drag": {"cd": 0.5},
        "magnus": {"cm": 0.09},
        "table_bounce": {"restitution": 0.92, "friction": 0.25},
    }
)
WITHOUT_MAGNUS = Simulator.from_dict(
    {name: values for name, values in NOMINAL.to_dict().items() if name != "magnus"}
)
RATE = 200.0
NOISE = Noise(white=0.003, slow=1e-5, label=0.05, label_common=1e-3, scatter=(0.01, 0.02, 0.005))
SETTINGS = GapSettings()


def launches(count, random):
    """States of balls over the net from both ends in turn, so that they bounce once."""
    side = np.where(np.arange(count) % 2, 1.0, -1.0)
    low = np.array([-0.3, 1.2, 0.15, -1.0, 4.0, -0.5, -250.0, -80.0, -120.0])
    high = np.array([0.3, 1.5, 0.4, 1.0, 9.0, 2.0, 250.0, 80.0, 120.0])
    states = random.uniform(low, high, (count, 9))
    states[:, 1] *= -side
    states[:, 4] *= side
    return states


def measured(
    simulator=NOMINAL,
    count=40,
    seed=0,
    labels="rows",
    seconds=0.75,
    noise=0.003,
    label=0.05,
    scatter=(0.01, 0.02, 0.005),
):
    """Shots measured with noise; ``labels`` are in "rows", "one" a shot, or None."""
    random = np.random.default_rng(seed)
    states = launches(count, random)
    times = np.tile(np.arange(0.0, seconds, 1 / RATE), (count, 1))
    kicks = np.tile(random.standard_normal((count, 3)) * scatter, 2)
    prediction = predict_measurements(
        simulator, Schedule.of_times(times), np.hstack([states, kicks])
    )
    second = simulator.fly(states, times).contacts.time[:, 1]
    kept = [np.flatnonzero(~(t > end - 0.02)) for t, end in zip(times, second, strict=True)]
    positions = prediction.positions + noise * random.standard_normal(prediction.positions.shape)
    size = np.linalg.norm(prediction.labels, axis=-1, keepdims=True)
    spins = prediction.labels + label * size * random.standard_normal(prediction.labels.shape)
    rows = [k[: {"rows": None, "one": 1, None: 0}[labels]] for k in kept]
    return Shots.from_arrays(
        [t[k] + 7.0 for t, k in zip(times, kept, strict=True)],
        [p[k] for p, k in zip(positions, kept, strict=True)],
        [w[k] for w, k in zip(spins, rows, strict=True)],
        [t[k] + 7.0 for t, k in zip(times, rows, strict=True)],
    )


def listed(simulator):
    """Hypotheses about the parameters that a simulator lists."""
    return tuple(one for one in hypotheses(simulator) if one.listed(simulator))
