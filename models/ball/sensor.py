"""The sensor: what cameras make of the true path.

Sensor effects are numpy functions of the true ball; they act once a measurement, not once a step.
"""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from models.ball.catalogue import catalogue
from models.ball.quantities import QUANTITIES, View
from models.ball.simulator import Simulator
from models.ball.state import POSITION, SPIN, VELOCITY
from models.ball.types import Floats

_SENSOR = {quantity.name: quantity for quantity in QUANTITIES if quantity.acts == "sensor"}


def measured(
    simulator: Simulator, states: Floats, times: Floats, generator: np.random.Generator
) -> tuple[Floats, Floats]:
    """Return what the simulator's sensor effects make of B balls, without noise.

    Args:
        simulator: flies the balls; its sensor effects distort what is seen.
        states: (B, 9) true states at time zero.
        times: (T,) s on the sensor's own clock.
        generator: draws which shots have a negated spin label.

    Returns:
        (B, T, 3) measured positions in m and (B, T, 3) spin labels in rad/s.
    """
    true_times = np.asarray(times, dtype=np.float64) / sensor_quantity(simulator, "clock_gain")
    flown = simulator.fly(states, true_times).states
    speed = np.linalg.norm(flown[..., VELOCITY], axis=-1)
    delay = np.broadcast_to(sensor_quantity(simulator, "delay", View(speed)), speed.shape)
    seen = _flown_in_any_order(simulator, states, true_times - delay)
    positions = sensor_quantity(simulator, "position_gain") * seen[..., POSITION]
    return positions, _spin_labels(simulator, flown[..., SPIN], generator)


def _flown_in_any_order(simulator: Simulator, states: Floats, times: Floats) -> Floats:
    """Return states at (B, T) times that may fall, as a delay that grows with speed makes them."""
    order = np.argsort(times, axis=1, kind="stable")
    flown = simulator.fly(states, np.take_along_axis(times, order, axis=1)).states
    original = np.argsort(order, axis=1, kind="stable")
    ordered: Floats = np.take_along_axis(flown, original[..., None], axis=1)
    return ordered


def _spin_labels(simulator: Simulator, spins: Floats, generator: np.random.Generator) -> Floats:
    turn = Rotation.from_rotvec(np.array(sensor_quantity(simulator, "spin_label_rotation")))
    labels = sensor_quantity(simulator, "spin_label_gain") * turn.apply(spins.reshape(-1, 3))
    flipped = generator.random(len(spins)) < sensor_quantity(simulator, "spin_flip_share")
    signed: Floats = np.where(flipped[:, None, None], -1.0, 1.0) * labels.reshape(spins.shape)
    return signed


def sensor_quantity(simulator: Simulator, name: str, view: View | None = None) -> Any:
    """Return a quantity of the sensor: its start, plus all that adds, times all that scales.

    Args:
        simulator: whose sensor effects change it.
        name: of a quantity of the sensor.
        view: the balls as they are when they are measured, for effects that look at them.
    """
    quantity = _SENSOR[name]
    value: Any = quantity.start if quantity.size == 1 else np.full(quantity.size, quantity.start)
    changes = [
        (change, simulator.effects[effect.name])
        for effect in catalogue().values()
        for change in effect.changes
        if change.quantity == name and effect.name in simulator.effects
    ]
    context = View(np.zeros(())) if view is None else view
    for change, parameters in sorted(changes, key=lambda item: item[0].how):
        term = change.function(context, *parameters.values())
        value = value + term if change.how == "adds" else value * term
    return value
