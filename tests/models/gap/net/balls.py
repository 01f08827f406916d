"""Simulated balls that meet the net, measured before and after it."""

import numpy as np

from rallygap.models.ball.contact_laws import NET
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.net.contacts import NetContacts
from tests.models.gap.hidden import NOMINAL, RATE

NET_LAW = {"restitution": 0.3, "friction": 0.4}
WITH_NET = NOMINAL.amended("net", **NET_LAW)


def meeting(count, seed=0, height=(0.08, 0.12)):
    """(B, 9) states of balls that reach the net at about these heights after 60 ms."""
    random = np.random.default_rng(seed)
    ahead = np.zeros((count, 9))
    side = np.where(np.arange(count) % 2, 1.0, -1.0)
    ahead[:, 0] = random.uniform(-0.5, 0.5, count)
    ahead[:, 2] = random.uniform(*height, count)
    ahead[:, 3] = random.uniform(-1.0, 1.0, count)
    ahead[:, 4] = side * random.uniform(3.0, 9.0, count)
    ahead[:, 5] = random.uniform(-0.3, 0.3, count)
    ahead[:, 6:] = random.uniform(-150.0, 150.0, (count, 3))
    times = np.full((count, 1), -0.06)
    return NOMINAL.without_surfaces().fly(ahead, times).states[:, 0]


def contacts(simulator=WITH_NET, count=60, seed=0, noise=0.002, scatter=0.02, **where):
    """Contacts with a simulator's net; velocities after it scatter by a share of the speed."""
    random = np.random.default_rng(seed)
    states = meeting(count, seed, **where)
    met = simulator.fly(states, [0.0, 0.2]).contacts
    assert (met.surface[:, 0] == NET).all()
    leaving = met.after[:, 0].copy()
    speed = np.abs(met.before[:, 0, 4])[:, None]
    leaving[:, 3:6] += scatter * speed * random.standard_normal((count, 3))
    before, after = [], []
    for row, moment in enumerate(met.time[:, 0]):
        first = np.arange(0.0, moment, 1 / RATE)
        second = np.arange(first[-1] + 1 / RATE, moment + 0.06, 1 / RATE)
        one = simulator.fly(states[row], first).states[0, :, :3]
        two = NOMINAL.without_surfaces().fly(leaving[row], second - moment).states[0, :, :3]
        before.append((first, one + noise * random.standard_normal(one.shape)))
        after.append((second, two + noise * random.standard_normal(two.shape)))
    labels = [met.before[row, 0, 6:][None] for row in range(count)], [np.zeros(1)] * count
    return NetContacts(
        Shots.from_arrays(*zip(*before, strict=True), *labels),
        Shots.from_arrays(*zip(*after, strict=True)),
    )
