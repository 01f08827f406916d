"""Naming the net: which of its values differ from a simulator's, and what that is worth."""

import pytest

from rallygap.models.gap.diagnose import diagnose
from rallygap.models.gap.settings import DEFAULTS
from tests.models.gap.hidden import NOMINAL, measured
from tests.models.gap.net.balls import NET_LAW, WITH_NET, contacts

SHOTS = measured(count=24)


def verdict(simulator=NOMINAL, withheld=(), **settings):
    return diagnose(SHOTS, simulator, DEFAULTS, withheld, contacts(**settings))


def named(found):
    return {cause.identity: cause for cause in found.main_causes}


def test_a_missing_net_is_named_and_its_paths_are_predicted():
    found = verdict()
    assert found.verdict == "named"
    causes = named(found)
    assert set(causes) == {"net.restitution", "net.friction"}
    for parameter, value in NET_LAW.items():
        cause = causes[f"net.{parameter}"]
        assert (cause.role, cause.kind) == ("leading", "missing_effect")
        assert cause.interval[0] < value < cause.interval[1]
        assert cause.worth.interval[0] > 0.0
    assert causes["net.restitution"].estimate == pytest.approx(NET_LAW["restitution"], abs=0.05)
    assert found.net.contacts > 40 and found.net.held_out > 10
    assert found.net.after_mm < 0.2 * found.net.before_mm


def test_a_wrong_value_of_the_net_is_named_alone():
    found = named(verdict(NOMINAL.amended("net", restitution=0.7, friction=NET_LAW["friction"])))
    assert set(found) == {"net.restitution"}
    assert found["net.restitution"].kind == "wrong_value"


def test_nothing_is_named_where_the_simulator_has_the_right_net():
    found = verdict(WITH_NET)
    assert (found.verdict, found.causes) == ("no_gap", ())
    assert found.net.before_mm == found.net.after_mm


@pytest.mark.parametrize("settings", [{"count": 8}, {"withheld": ("net",)}])
def test_too_few_contacts_and_a_withheld_net_say_nothing(settings):
    found = verdict(**settings)
    assert (found.net, found.causes) == (None, ())
