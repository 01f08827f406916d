"""Omnibus terms reproduce the catalogue's effects, by an independent way."""

import numpy as np
import pytest

from rallygap.models.ball.state import BALL_RADIUS
from rallygap.models.gap.fit.linearize import ballistic_nuisance, linearise
from rallygap.models.gap.hypotheses import Hypothesis, hypotheses
from rallygap.models.gap.locate.term_library import terms_about
from rallygap.models.gap.locate.terms import TYPICAL_FALL, TYPICAL_SPEED
from tests.models.gap.hidden import NOMINAL, launches, measured

COLUMNS = hypotheses(NOMINAL)
STATES = launches(8, np.random.default_rng(0))
LINEAR = linearise(measured(count=8), NOMINAL, ballistic_nuisance(STATES, 2), COLUMNS)
BASIS = terms_about(LINEAR)
DRAG, LIFT = 0.2793, 0.01489  # of C_D |u| u in 1/m, and of C_M w x u


def term(name):
    return next(k for k, one in enumerate(BASIS.terms) if one.parameter == name)


def effect_of(identity):
    """Derivatives of positions and of labels by a parameter of the catalogue."""
    column = LINEAR.nuisance_count + COLUMNS.index(Hypothesis.from_identity(identity))
    return LINEAR.positions[..., column], LINEAR.labels[..., column]


@pytest.mark.parametrize(
    ("identity", "terms", "factor"),
    [
        ("gravity.g", ["z"], -1.0),
        ("drag.cd", ["u (|u|/8)^1"], -DRAG * TYPICAL_SPEED),
        ("magnus.cm", ["w x u"], LIFT * TYPICAL_SPEED / BALL_RADIUS),
        ("position_scale.s", ["x at x", "y at y", "z at z"], 1.0),
        ("spin_decay.c", ["-w (|u|/8)^1"], TYPICAL_SPEED),
    ],
)
def test_terms_reproduce_effects(identity, terms, factor):
    found = factor * sum(BASIS.positions[..., term(name)] for name in terms)
    effect, _ = effect_of(identity)
    assert np.abs(effect).max() > 0.0
    # At a bounce the law of the ball before it counts.
    assert found == pytest.approx(effect, abs=0.03 * np.abs(effect).max())


def test_kicks_and_labels_do_what_effects_do():
    effect = effect_of("speed_dependent_restitution.c")[0][..., 2]
    heights = BASIS.positions[..., 2, :]
    by_speed = TYPICAL_FALL * heights[..., term("n v_n")]
    found = 2.5 * heights[..., term("n")] - by_speed
    assert found == pytest.approx(effect, abs=0.03 * np.abs(by_speed).max())
    gain, decay = (effect_of(one)[1] for one in ("spin_gain.s", "spin_decay.c"))
    assert BASIS.labels[..., term("w")] == pytest.approx(gain, abs=1e-6)
    found = TYPICAL_SPEED * BASIS.labels[..., term("-w (|u|/8)^1")]
    assert found == pytest.approx(decay, abs=0.03 * np.abs(decay).max())


def test_all_effects_lie_in_the_span_of_terms():
    def rows(places, labels):
        """Rows in units of their noise."""
        return np.concatenate([a.reshape(-1, a.shape[-1]) for a in (places / 0.003, labels / 0.05)])

    terms = rows(BASIS.positions, BASIS.labels)
    effects = rows(LINEAR.positions, LINEAR.labels)[:, LINEAR.nuisance_count : -1]
    scale = np.linalg.norm(terms, axis=0) + 1e-12
    left = effects - terms / scale @ np.linalg.lstsq(terms / scale, effects, rcond=1e-6)[0]
    assert np.all((left**2).sum(axis=0) <= 0.02 * (effects**2).sum(axis=0))


def test_shots_without_labels_or_bounces_have_a_basis():
    shots = measured(count=3, labels=None, seconds=0.15)
    linear = linearise(shots, NOMINAL, ballistic_nuisance(STATES[:3], 0), COLUMNS)
    found = terms_about(linear)
    assert [one.parameter for one in found.terms] == [one.parameter for one in BASIS.terms]
    assert found.labels.shape[1] == 0
    assert not found.positions[..., term("n v_n")].any()
    assert found.positions[..., term("z")].any()
