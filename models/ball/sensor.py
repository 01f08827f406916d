"""The sensor: systematic errors of measured positions, times and spin labels.

Sensor effects are numpy functions of the true ball, applied once per measurement.
Every simulated or predicted measurement goes through the functions here.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from rallygap.models.ball.quantities import QUANTITIES, View
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, SPIN, VELOCITY
from rallygap.models.ball.types import Floats

MAX_DELAY = 1.0  # s, where trial values make a ball ever faster

_SENSOR = {quantity.name: quantity for quantity in QUANTITIES if quantity.acts == "sensor"}


def measured(
    simulator: Simulator, states: Floats, times: Floats, generator: np.random.Generator
) -> tuple[Floats, Floats]:
    """Return measurements of B balls with the simulator's sensor effects, without noise.

    Args:
        simulator: of the flight and of the sensor.
        states: (B, 9) true states at time zero.
        times: (T,) s on the sensor's own clock.
        generator: draws which shots have a negated spin label.

    Returns:
        (B, T, 3) measured positions in m and (B, T, 3) spin labels in rad/s.
    """
    true = true_times(simulator, times)
    flown = simulator.fly(states, true).states
    speeds = np.linalg.norm(flown[..., VELOCITY], axis=-1)

    def fly(moments: Floats) -> Floats:
        return simulator.fly(states, moments).states

    seen = in_rising_order(fly, true - delays(simulator, speeds))
    labels = measured_spins(simulator, flown[..., SPIN])
    flipped = generator.random(len(labels)) < sensor_quantity(simulator, "spin_flip_share")
    signed = np.where(flipped[:, None, None], -1.0, 1.0) * labels
    return measured_positions(simulator, seen[..., POSITION]), signed


def true_times(simulator: Simulator, times: Floats) -> Floats:
    """Return the true times, s, of times on the sensor's clock."""
    return np.asarray(times, dtype=np.float64) / sensor_quantity(simulator, "clock_gain")


def clock_times(simulator: Simulator, times: Floats) -> Floats:
    """Return the times on the sensor's clock, s, of true times."""
    return sensor_quantity(simulator, "clock_gain") * times


def delays(simulator: Simulator, speeds: Floats) -> Floats:
    """Return (...) ages of measured positions, s, of balls at (...) speeds, m/s."""
    delay = np.minimum(sensor_quantity(simulator, "delay", View(speeds)), MAX_DELAY)
    return np.broadcast_to(delay, np.shape(speeds))


def measured_positions(simulator: Simulator, positions: Floats) -> Floats:
    """Return (..., 3) measured positions, m, of balls at true positions."""
    gain = sensor_quantity(simulator, "position_gain")
    view = View(np.zeros(()), positions)
    return gain * positions + sensor_quantity(simulator, "position_error", view)


def measured_spins(simulator: Simulator, spins: Floats) -> Floats:
    """Return (..., 3) spin labels, rad/s, of true spins; signs are right."""
    turn = Rotation.from_rotvec(np.array(sensor_quantity(simulator, "spin_label_rotation")))
    turned = turn.apply(spins.reshape(-1, 3)).reshape(spins.shape) if spins.size else spins
    return sensor_quantity(simulator, "spin_label_gain") * turned


def in_rising_order(fly: Callable[[Floats], Floats], times: Floats) -> Floats:
    """Return states at (B, T) times in any order; a delay that grows with speed may reorder them.

    Args:
        fly: gives (B, T, 9) states at (B, T) rising times.
        times: s.
    """
    order = np.argsort(times, axis=1, kind="stable")
    flown = fly(np.take_along_axis(times, order, axis=1))
    original = np.argsort(order, axis=1, kind="stable")
    return np.take_along_axis(flown, original[..., None], axis=1)


def sensor_quantity(simulator: Simulator, name: str, view: View | None = None) -> Any:
    """Return a quantity of the sensor: its start, plus all added terms, times all factors.

    Args:
        simulator: with the sensor effects.
        name: of a quantity of the sensor.
        view: the balls at the measurement, for effects that depend on them.
    """
    quantity = _SENSOR[name]
    value: Any = quantity.start if quantity.size == 1 else np.full(quantity.size, quantity.start)
    context = View(np.zeros(())) if view is None else view
    for change, parameters in simulator.sensor_changes.get(name, ()):
        term = change.function(context, *parameters)
        value = value + term if change.how == "adds" else value * term
    return value
