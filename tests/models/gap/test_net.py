"""The net: contacts simulated and measured, velocities, estimates of its law, and naming."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.ball.contact_laws import NET
from rallygap.models.gap.diagnose import diagnose
from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.name.naming import name
from rallygap.models.gap.net.contacts import NetContacts
from rallygap.models.gap.net.impacts import Impacts
from rallygap.models.gap.net.law import NetLaw
from rallygap.models.gap.net.naming import name_net
from rallygap.models.gap.settings import Question
from tests.models.gap.hidden import NOMINAL, RATE, SETTINGS, measured

EXACT = Noise(white=2e-5, slow=1e-5)
SHOTS = measured(count=24)
NET_LAW = {"restitution": 0.3, "friction": 0.4}
WITH_NET = NOMINAL.amended("net", **NET_LAW)


def meeting(count, seed):
    """(B, 9) states of balls that reach the net at about these heights after 60 ms."""
    random = np.random.default_rng(seed)
    ahead = np.zeros((count, 9))
    side = np.where(np.arange(count) % 2, 1.0, -1.0)
    ahead[:, 0] = random.uniform(-0.5, 0.5, count)
    ahead[:, 2] = random.uniform(0.08, 0.12, count)
    ahead[:, 3] = random.uniform(-1.0, 1.0, count)
    ahead[:, 4] = side * random.uniform(3.0, 9.0, count)
    ahead[:, 5] = random.uniform(-0.3, 0.3, count)
    ahead[:, 6:] = random.uniform(-150.0, 150.0, (count, 3))
    times = np.full((count, 1), -0.06)
    return NOMINAL.without_surfaces().fly(ahead, times).states[:, 0]


def contacts(simulator=WITH_NET, count=60, seed=0, noise=0.002, scatter=0.02):
    """Contacts with a simulator's net; velocities after it scatter by a share of the speed."""
    random = np.random.default_rng(seed)
    states = meeting(count, seed)
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


def test_measured_velocities_are_those_of_the_law_of_the_net():
    measured = contacts(noise=1e-5, scatter=0.0)
    impacts = Impacts.of(measured, NOMINAL, EXACT, SETTINGS)
    assert len(impacts) == len(measured)
    np.testing.assert_allclose(impacts.after, impacts.velocities(WITH_NET), atol=0.03)
    across = impacts.after[:, 1] / impacts.velocities(NOMINAL)[:, 1]
    np.testing.assert_allclose(across, -NET_LAW["restitution"], atol=0.01)
    near = WITH_NET.amended("net", restitution=0.4)
    sizes = [impacts.squares(one, SETTINGS).mean() for one in (WITH_NET, near, NOMINAL)]
    assert sizes[0] < 1e-6
    assert sizes == sorted(sizes)


@pytest.mark.parametrize("height", [0.155, 0.5])
def test_contacts_at_the_cord_or_above_it_are_no_impacts(height):
    measured = contacts(noise=1e-4, scatter=0.0)
    higher = np.array([0.0, 0.0, height - 0.08])
    moved = measured.changed(lambda arcs: replace(arcs, positions=arcs.positions + higher))
    assert len(Impacts.of(moved, NOMINAL, EXACT, SETTINGS)) < 0.7 * len(measured)


TRUE = np.array([NET_LAW["restitution"], NET_LAW["friction"]])


def law(**settings):
    impacts = Impacts.of(contacts(**settings), NOMINAL, Noise(white=0.002, slow=1e-4), SETTINGS)
    return NetLaw(impacts, NOMINAL, SETTINGS)


def test_intervals_hold_the_true_values_about_as_often_as_they_say():
    laws = [law(count=40, seed=seed) for seed in range(5)]
    held = np.array([[np.subtract(found.interval(k), TRUE[k]) for k in (0, 1)] for found in laws])
    inside = (held[..., 0] <= 0.0) & (held[..., 1] >= 0.0)
    assert inside.sum() >= 8  # of 10 at 95 %: fewer with a probability of 1e-2
    assert np.ptp(held[:, 0], axis=-1).max() < 0.15  # friction no longer acts once a ball rolls


def test_the_estimate_is_the_likeliest_and_a_few_odd_contacts_change_little():
    found = law()
    assert found.deviance <= found.deviance_of(WITH_NET)
    assert found.deviance < found.deviance_of(NOMINAL) - 100.0
    found = law(scatter=0.01)
    odd = found.impacts.after.copy()
    odd[:6] += 5.0
    others = replace(found, impacts=replace(found.impacts, after=odd))
    np.testing.assert_allclose(others.estimate, found.estimate, atol=0.02)


def test_a_missing_net_is_named_and_its_paths_are_predicted():
    found = diagnose(SHOTS, NOMINAL, SETTINGS, (), contacts())
    assert found.verdict == "named"
    causes = {cause.identity: cause for cause in found.main_causes}
    assert set(causes) == {"net.restitution", "net.friction"}
    for parameter, value in NET_LAW.items():
        cause = causes[f"net.{parameter}"]
        assert (cause.role, cause.kind) == ("leading", "missing_effect")
        assert cause.interval[0] < value < cause.interval[1]
        assert cause.worth.interval[0] > 0.0
    assert causes["net.restitution"].estimate == pytest.approx(NET_LAW["restitution"], abs=0.05)
    assert found.net.contacts > 40 and found.net.held_out > 10
    assert found.net.after_mm < 0.2 * found.net.before_mm


def named_net(simulator):
    question = Question(simulator)
    return name_net(contacts(), name(SHOTS, question), question)


def test_a_wrong_value_is_named_alone_and_nothing_of_the_right_net():
    (cause,) = named_net(WITH_NET.amended("net", restitution=0.7)).causes
    assert (cause.identity, cause.kind) == ("net.restitution", "wrong_value")
    right = named_net(WITH_NET)
    assert right.causes == ()
    assert right.errors.before_mm == right.errors.after_mm


def test_too_few_contacts_and_a_withheld_net_say_nothing():
    named = name(SHOTS, Question(NOMINAL))
    assert name_net(contacts(count=8), named, Question(NOMINAL)) is None
    assert name_net(contacts(), named, Question(NOMINAL, withheld=("net",))) is None
