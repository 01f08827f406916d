"""The audit finds the effects of an engine, and nothing that it does not have."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rallygap.models.audit.audit import audit
from rallygap.models.audit.bounces import SHELL
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.simulators import shipped, shipped_names
from rallygap.models.ball.state import POSITION
from rallygap.models.engines.engine import EffectsEngine, FunctionEngine

PLAIN = {"gravity": {"g": 9.81}, "table_bounce": {"restitution": 0.92, "friction": 0.25}}
# Ranges in which each effect matters by more than the threshold.
FLIGHT = {
    "drag": {"cd": (0.2, 0.7)},
    "magnus": {"cm": (0.03, 0.3)},
    "wind": {"x": (-0.5, 0.5), "y": (-0.5, 0.5)},
    "frame_tilt": {"x": (-0.02, 0.02)},
    "spin_decay": {"c": (0.003, 0.02)},
    "side_force": {"cy": (0.02, 0.1)},
}
TABLE = {
    "tangential_elasticity": {"et": (0.05, 0.4)},
    "speed_dependent_restitution": {"c": (0.005, 0.03)},
    "table_height": {"h": (-0.01, 0.01)},
    "table_tilt": {"x": (-0.01, 0.01)},
}


def values(ranges):
    return st.fixed_dictionaries({name: st.floats(*ends) for name, ends in ranges.items()})


def some_of(effects):
    return st.fixed_dictionaries(
        {}, optional={name: values(ranges) for name, ranges in effects.items()}
    )


def audited(simulator, patience=1e-9):
    """The audit of a simulator; by the fewest probes unless patience is longer."""
    return audit(EffectsEngine("mine", simulator), patience=patience)


@pytest.mark.parametrize("name", shipped_names())
def test_a_shipped_simulator_is_found_as_it_is(name):
    truth = shipped(name)
    found = audited(truth, patience=np.inf)
    names = set(truth.effects) - {"net", "racket_bounce"}
    assert {one.hypothesis.effect for one in found.effects} == names
    for one in found.effects:
        assert one.value == pytest.approx(one.hypothesis.value(truth), rel=1e-4, abs=1e-6)
    assert max(one.largest_mm for one in found.unexplained.values()) < 0.01


@settings(max_examples=6, deadline=None)
@given(some_of(FLIGHT), some_of(TABLE))
def test_lists_are_found_again_within_a_percent(flight, table):
    truth = Simulator.from_dict({**PLAIN, **flight, **table})
    found = audited(truth)
    for one in found.effects:
        assert one.value == pytest.approx(one.hypothesis.value(truth), rel=0.01, abs=1e-3)
    assert max(one.largest_mm for one in found.unexplained.values()) < 2.0


def test_an_engine_that_takes_longer_than_patience_gets_fewer_probes():
    shares = []
    found = audit(EffectsEngine("mine", Simulator.from_dict(PLAIN)), shares.append, 1e-9)
    assert found.probes == {"flight": 24, "table": 30}
    assert {one.hypothesis.effect for one in found.effects} == set(PLAIN)
    assert np.nanmax(found.bounces.grip) == pytest.approx(SHELL, rel=1e-3)
    assert found.bounces.restitution == pytest.approx(0.92)
    assert shares == sorted(shares) and shares[-1] == 1.0


def test_an_engine_without_a_table_is_audited_in_flight():
    found = audited(Simulator.from_dict({"gravity": {"g": 9.81}, "drag": {"cd": 0.5}}))
    assert found.bounces is None
    assert set(found.simulator.effects) == {"gravity", "drag"}


def test_what_no_effect_explains_is_said_in_millimetres():
    truth = Simulator.from_dict(PLAIN)

    def pulled(states, times):
        flown = truth.fly(states, times).states
        flown[..., POSITION] += 0.02 * np.sin(20.0 * times)[:, None]
        return flown

    found = audit(FunctionEngine("mine", pulled))
    assert found.unexplained["flight"].median_mm > 5.0
