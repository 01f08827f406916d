"""Sensor terms: errors of positions that grow with place, speed and time, and of labels."""

import numpy as np

from models.ball.state import POSITION, SPIN, VELOCITY
from models.ball.types import Floats
from models.gap.locate.terms import Flown, Term, Terms

TYPICAL_SPIN = 200.0  # rad/s
TYPICAL_TIME = 0.3  # s


def of_sensor(flown: Flown) -> Terms:
    """Return the terms of the sensor: what it adds to places and labels of balls."""
    shots = flown.linear.shots
    start = shots.times[:, :1]
    places, velocities = flown.sampled[..., POSITION], flown.sampled[..., VELOCITY]
    of_places = _of_places(places, velocities, (shots.times - start)[..., None])
    since = np.nan_to_num(shots.label_times - start)
    of_labels = _of_labels(
        flown.labelled[..., SPIN], flown.label_scales[..., None], since[..., None]
    )
    names = [Term("sensor", name) for name in (*of_places, *of_labels)]
    positions = np.zeros((*shots.positions.shape, len(names)))
    labels = np.zeros((*shots.labels.shape, len(names)))
    positions[..., : len(of_places)] = np.stack(list(of_places.values()), axis=-1)
    labels[..., len(of_places) :] = np.stack(list(of_labels.values()), axis=-1)
    return Terms(tuple(names), positions, labels)


def _of_places(place: Floats, velocity: Floats, time: Floats) -> dict[str, Floats]:
    """Return the errors of (B, N, 3) places."""
    axes = dict(zip("xyz", np.eye(3), strict=True))
    errors = {
        f"{axis} at {other}": place[..., [column]] * direction
        for axis, direction in axes.items()
        for column, other in enumerate("xyz")
    }
    speed = np.linalg.norm(velocity, axis=-1, keepdims=True)
    return {**errors, "-u |u|": -velocity * speed, "-u t": -velocity * time}


def _of_labels(spins: Floats, units: Floats, time: Floats) -> dict[str, Floats]:
    """Return the errors of (B, L, 3) labels, in their units."""
    shares = spins / units
    turned = {f"{axis} x w": np.cross(np.eye(3)[k], shares) for k, axis in enumerate("xyz")}
    growing = {"w |w|": shares * units / TYPICAL_SPIN, "w t": shares * time / TYPICAL_TIME}
    return {"w": shares, **growing, **turned}
