"""Explanations: the fewest causes that suffice, and their rivals, in a linear world."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.inference.score_test import Evidence
from rallygap.models.gap.name.selection import Explainer, best_explanation
from tests.models.gap.hidden import SETTINGS

NOMINAL = Simulator.from_dict({"gravity": {"g": 9.81}, "drag": {"cd": 0.5}})
COLUMNS = (
    Hypothesis("gravity", "g"),
    Hypothesis("drag", "cd"),
    Hypothesis("wind", "x"),
    Hypothesis("wind", "y"),
    Hypothesis("wind", "z"),
    Hypothesis("buoyancy", "b"),
)
G, CD, X, Y, Z, B = range(6)
LEVEL = 0.003


def weighed(columns, listed, rows, measured):
    """An explainer of measurements in unit noise by (B, R, K) rows."""
    scores, information = np.einsum("bri,br->bi", rows, measured), np.swapaxes(rows, 1, 2) @ rows
    return Explainer(Evidence(columns, listed, scores, information, SETTINGS), NOMINAL)


def explainer(seed=0, of_drag=0.0, **effect):
    """A world of 10 measurements a shot; B is G, or of CD, too, and X is Y + Z, nearly."""
    random = np.random.default_rng(seed)
    rows = random.standard_normal((60, 10, 6))
    rows[..., B] = 2 * rows[..., G] + of_drag * rows[..., CD]
    rows[..., X] = rows[..., Y] + rows[..., Z] + 0.05 * rows[..., X]
    values = np.array([effect.get(name, 0.0) for name in ("g", "cd", "x", "y", "z", "b")])
    measured = rows @ values + random.standard_normal((60, 10))
    return weighed(COLUMNS, np.array([one.listed(NOMINAL) for one in COLUMNS]), rows, measured)


@pytest.mark.parametrize(
    ("world", "of_drag", "causes"),
    [
        ({}, 0.0, ()),
        # One cause is preferred to two that explain as much,
        ({"x": 0.5}, 0.0, (X,)),
        ({"y": 0.5, "z": 0.5}, 0.0, (X,)),
        ({"y": 0.5}, 0.0, (Y,)),
        # a listed parameter to a missing effect that it absorbs,
        ({"b": 0.5}, 0.0, (G,)),
        # a missing effect to two listed parameters that absorb it,
        ({"b": 0.2}, -1.0, (B,)),
        # and these to a missing effect that explains less.
        ({"g": 0.4, "cd": 0.3}, -1.0, (G, CD)),
        ({"cd": -0.3}, -1.0, (CD,)),
    ],
)
def test_the_fewest_causes_that_suffice_are_found(world, of_drag, causes):
    weighing = explainer(of_drag=of_drag, **world)
    assert best_explanation(weighing).causes == causes
    if causes == (G,):
        assert weighing.absorbed == (B,)
    if causes == (B,):
        assert weighing.alternatives(B, (B,)) == (B, G, CD)


def test_no_cause_is_found_by_chance_or_by_one_shot():
    assert all(best_explanation(explainer(seed)).causes == () for seed in range(15))
    weighing = explainer()
    weighing.evidence.scores[7, Y] += 120.0
    assert best_explanation(weighing).causes == ()


def test_two_causes_are_found_with_their_sizes():
    weighing = explainer(y=0.4, cd=-0.3)
    found = best_explanation(weighing)
    assert found.causes == (CD, Y)
    assert max(found.p_values.values()) < LEVEL
    _, estimates = weighing.set_scores.gains(np.array([found.causes]))
    assert estimates[0] == pytest.approx([-0.3, 0.4], abs=0.15)


def test_alternatives_explain_as_much_in_the_place_of_a_cause():
    weighing = explainer(g=0.5, z=1.0)
    assert best_explanation(weighing).causes == (G, Z)
    assert weighing.alternatives(G, (G, Z)) == (G, B)
    assert weighing.alternatives(Z, (G, Z)) == (Z,)


def test_implausible_values_explain_nothing():
    weighing = explainer(cd=-0.9)
    assert weighing.set_scores.gains(np.array([[CD]]))[0][0] == -np.inf
    assert weighing.set_scores.gains(np.array([[Y]]))[0][0] > -np.inf


def test_refitted_causes_may_be_collinear():
    weighing = explainer(x=6.0, y=-6.5, z=-5.0)
    assert best_explanation(weighing).causes == (X, Y)
    assert best_explanation(replace(weighing, refitted=(X, Y, Z))).causes == (X, Y, Z)


def test_a_known_cause_that_the_shots_see_nothing_of_is_not_significant():
    blind = explainer(y=0.4)
    blind.evidence.scores[:, Z] = 0.0
    blind.evidence.information[:, Z] = blind.evidence.information[:, :, Z] = 0.0
    found = best_explanation(blind, required=(Z,))
    assert found.causes == (Y, Z)
    assert found.p_values[Z] == 1.0
    assert blind.evidence.score_test([Z], [Y]).estimate == 0.0


def random_world(causes, columns=40, shots=60, seed=0):
    """A world of numbers that look somewhat alike, ``causes`` of which are 10 errors off."""
    random = np.random.default_rng(seed)
    mixed = np.eye(columns) + 0.25 * random.standard_normal((columns, columns))
    rows = random.standard_normal((shots, 10, columns)) @ mixed
    information = np.swapaxes(rows, 1, 2) @ rows
    errors = np.sqrt(np.diag(np.linalg.inv(information.sum(axis=0))))
    values = np.isin(np.arange(columns), causes) * 10 * errors
    measured = rows @ values + random.standard_normal((shots, 10))
    names = tuple(Hypothesis("wind", "xyz"[k % 3]) for k in range(columns))
    return weighed(names, np.zeros(columns, dtype=bool), rows, measured)


@pytest.mark.parametrize("seed", range(2))
def test_twenty_causes_are_all_found_and_no_other(seed):
    causes = tuple(range(1, 40, 2))
    weighing = random_world(causes, seed=seed)
    assert best_explanation(weighing, most=25).causes == causes
