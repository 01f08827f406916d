"""Impacts: velocities before and after the net, by the arcs that were measured."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.net.impacts import Impacts
from tests.models.gap.hidden import NOMINAL, SETTINGS
from tests.models.gap.net.balls import NET_LAW, WITH_NET, contacts

EXACT = Noise(white=2e-5, slow=1e-5)


def test_measured_velocities_are_those_of_the_law_of_the_net():
    measured = contacts(noise=1e-5, scatter=0.0)
    impacts = Impacts.of(measured, NOMINAL, EXACT, SETTINGS)
    assert len(impacts) == len(measured)
    np.testing.assert_allclose(impacts.after, impacts.velocities(WITH_NET), atol=0.03)
    across = impacts.after[:, 1] / impacts.velocities(NOMINAL)[:, 1]
    np.testing.assert_allclose(across, -NET_LAW["restitution"], atol=0.01)


def test_a_net_less_far_from_the_truth_predicts_better():
    impacts = Impacts.of(contacts(noise=1e-5, scatter=0.0), NOMINAL, EXACT, SETTINGS)
    near = WITH_NET.amended("net", restitution=0.4)
    sizes = [impacts.squares(one, SETTINGS).mean() for one in (WITH_NET, near, NOMINAL)]
    assert sizes[0] < 1e-6
    assert sizes == sorted(sizes)


@pytest.mark.parametrize("height", [(0.155, 0.165), (0.5, 0.6)])
def test_contacts_at_the_cord_or_above_it_are_no_impacts(height):
    measured = contacts(noise=1e-4, scatter=0.0)
    moved = measured.changed(lambda arcs: raised(arcs, height[0] - 0.08))
    assert len(Impacts.of(moved, NOMINAL, EXACT, SETTINGS)) < 0.7 * len(measured)


def raised(arcs, height):
    """The arcs, higher by so many m."""
    return replace(arcs, positions=arcs.positions + np.array([0.0, 0.0, height]))
