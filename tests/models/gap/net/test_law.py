"""The law of the net: estimates, intervals and outliers."""

import numpy as np

from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.net.impacts import Impacts
from rallygap.models.gap.net.law import NetLaw
from tests.models.gap.hidden import NOMINAL, SETTINGS
from tests.models.gap.net.balls import NET_LAW, WITH_NET, contacts

TRUE = np.array([NET_LAW["restitution"], NET_LAW["friction"]])


def law(**settings):
    impacts = Impacts.of(contacts(**settings), NOMINAL, Noise(white=0.002, slow=1e-4), SETTINGS)
    return NetLaw(impacts, NOMINAL, SETTINGS)


def test_intervals_hold_the_true_values_about_as_often_as_they_say():
    laws = [law(count=40, seed=seed) for seed in range(10)]
    held = np.array([[np.subtract(found.interval(k), TRUE[k]) for k in (0, 1)] for found in laws])
    inside = (held[..., 0] <= 0.0) & (held[..., 1] >= 0.0)
    assert inside.sum() >= 16  # of 20 at 95 %: fewer with a probability of 2e-3
    assert np.ptp(held[:, 0], axis=-1).max() < 0.15  # friction no longer acts once a ball rolls


def test_the_estimate_is_the_likeliest():
    found = law()
    assert found.deviance <= found.deviance_of(WITH_NET)
    assert found.deviance < found.deviance_of(NOMINAL) - 100.0


def test_a_few_contacts_that_go_elsewhere_change_little():
    found = law(scatter=0.01)
    odd = found.impacts.after.copy()
    odd[:6] += 5.0
    others = NetLaw(
        Impacts(**{**vars(found.impacts), "after": odd}), found.simulator, found.settings
    )
    np.testing.assert_allclose(others.estimate, found.estimate, atol=0.02)
