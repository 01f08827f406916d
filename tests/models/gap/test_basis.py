"""Basis: its terms are what the catalogue's effects do, by an independent way."""

import numpy as np
import pytest

from models.ball.state import BALL_RADIUS
from models.gap.basis import TYPICAL_FALL, TYPICAL_SPEED, basis
from models.gap.hypotheses import Hypothesis
from models.gap.linear import ballistic_unknowns, linearise
from tests.models.gap.hidden import NOMINAL, launches, measured

COLUMNS = (
    Hypothesis("gravity", "g"),
    Hypothesis("drag", "cd"),
    Hypothesis("magnus", "cm"),
    Hypothesis("speed_dependent_restitution", "c"),
    Hypothesis("position_scale", "s"),
    Hypothesis("spin_gain", "s"),
    Hypothesis("spin_decay", "c"),
)
STATES = launches(8, np.random.default_rng(0))
LINEAR = linearise(measured(count=8), NOMINAL, ballistic_unknowns(STATES, 2), COLUMNS)
BASIS = basis(LINEAR)
DRAG, LIFT = 0.2793, 0.01489  # of C_D |u| u in 1/m, and of C_M w x u


def term(name):
    return next(k for k, one in enumerate(BASIS.terms) if one.parameter == name)


@pytest.mark.parametrize(
    ("column", "terms", "factor"),
    [
        (0, ["z"], -1.0),
        (1, ["u (|u|/8)^1"], -DRAG * TYPICAL_SPEED),
        (2, ["w x u"], LIFT * TYPICAL_SPEED / BALL_RADIUS),
        (4, ["x at x", "y at y", "z at z"], 1.0),
        (6, ["-w (|u|/8)^1"], TYPICAL_SPEED),
    ],
)
def test_terms_do_what_effects_do(column, terms, factor):
    found = factor * sum(BASIS.positions[..., term(name)] for name in terms)
    effect = LINEAR.positions[..., LINEAR.own + column]
    assert np.abs(effect).max() > 0.0
    # Labels do not follow a force; at a bounce the law of the ball before it counts.
    assert found == pytest.approx(effect, abs=0.03 * np.abs(effect).max())


def test_a_kick_upwards_does_what_restitution_does_to_the_height():
    effect = LINEAR.positions[..., 2, LINEAR.own + 3]
    found = -TYPICAL_FALL * BASIS.positions[..., 2, term("n v_n")]
    assert found == pytest.approx(effect, abs=0.03 * np.abs(effect).max())


def test_the_gain_of_labels_is_a_term():
    effect = LINEAR.labels[..., LINEAR.own + 5]
    assert BASIS.labels[..., term("w")] == pytest.approx(effect, abs=1e-6)


def test_terms_are_nobodys_own_numbers():
    assert not any(one.listed(NOMINAL) for one in BASIS.terms)
    assert {one.effect for one in BASIS.terms} == {"flight", "table", "sensor"}
