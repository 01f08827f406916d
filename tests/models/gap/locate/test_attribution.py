"""Locate: shares of causes sum to the gap, and trends point to the right covariate."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.refit import fit_nuisance
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.locate.attribution import Part, locate
from rallygap.models.gap.settings import Question
from rallygap.models.gap.verify.prediction_error import HeldOut
from tests.models.gap.hidden import NOISE, NOMINAL, SETTINGS, measured

EXACT = Noise(white=1e-4, slow=1e-5, label=0.01, label_common=1e-3, scatter=(1e-3, 1e-3, 1e-3))


def part(fit, identity, change, phase="flight"):
    """What a change of one parameter adds to the measurements."""
    column = fit.linear.nuisance_count + fit.linear.columns.index(
        Hypothesis.from_identity(identity)
    )
    positions, labels = fit.linear.positions[..., column], fit.linear.labels[..., column]
    return Part(identity, phase, change * positions, change * labels)


def fitted(truth, count=30, seed=1001):
    return fit_nuisance(measured(truth, count=count, seed=seed), NOMINAL, NOISE, SETTINGS.fit)


def located(truth, **settings):
    return locate(fitted(truth, **settings), Question(NOMINAL), [])


def test_nothing_is_attributed_without_a_cause():
    found = located(NOMINAL)
    assert found.phase_shares == {"flight": 0.0, "table": 0.0, "sensor": 0.0}
    assert (found.gap_shares, found.discrepancy.any()) == ({}, False)
    assert min(growth.p_value for growth in found.growth) > 0.01


def test_causes_share_the_gap_of_their_phases():
    fit = fitted(NOMINAL)
    found = locate(fit, Question(NOMINAL), [part(fit, "position_scale.s", 0.01, "sensor")])
    assert found.gap_shares == {"position_scale.s": pytest.approx(1.0)}
    assert found.phase_shares == {"flight": 0.0, "table": 0.0, "sensor": pytest.approx(1.0)}
    half = part(fit, "drag.cd", 0.02)
    found = locate(fit, Question(NOMINAL), [half, replace(half, identity="other")])
    assert found.gap_shares == pytest.approx({"drag.cd": 0.5, "other": 0.5})
    whole = locate(fit, Question(NOMINAL), [part(fit, "drag.cd", 0.04)])
    assert found.discrepancy == pytest.approx(whole.discrepancy)
    table = part(fit, "table_bounce.restitution", -0.025, "table")
    shares = locate(fit, Question(NOMINAL), [part(fit, "wind.x", 0.15), table]).shares
    assert shares["table"][1] < 0.1  # it counts from the bounce on
    assert shares["table"][-1] > 0.2
    np.testing.assert_allclose(sum(shares.values()), 1.0)


def test_the_discrepancy_is_the_error_of_predictions_of_exact_shots():
    truth = NOMINAL.amended("drag", cd=0.45)
    shots = measured(truth, count=16, noise=1e-5, label=1e-3, scatter=(0.0, 0.0, 0.0))
    about = fit_nuisance(shots, truth, EXACT, SETTINGS.fit)
    found = locate(about, Question(NOMINAL), [part(about, "drag.cd", -0.05)])
    held = HeldOut.of(about, shots, EXACT, SETTINGS)
    predicted = held.errors((NOMINAL, truth), (150.0, 150.0), shots)
    sizes = np.sqrt(np.nanmean(predicted.squares[0], axis=0))
    discrepancies = np.interp(predicted.horizons, found.horizons, found.discrepancy)
    np.testing.assert_allclose(discrepancies, sizes, rtol=0.1)


def test_a_cross_wind_shows_in_the_direction_of_play():
    most = located(NOMINAL.amended("wind", x=0.15)).growth[0]
    assert (most.covariate, most.kinds) == ("direction of play", ("towards −y", "towards +y"))
    assert most.p_value < 0.01
    # The wind blows towards +x: to the left of who looks towards −y.
    assert most.means[0, 1] < -most.margins[0, 1]
    assert most.means[1, 1] > most.margins[1, 1]


def test_too_strong_a_drag_grows_with_speed_and_time():
    found = located(NOMINAL.amended("drag", cd=0.56), count=48)
    assert found.growth[0].covariate == "speed at launch"
    assert found.growth[0].means[-1, 0] < 1.5 * found.growth[0].means[0, 0] < 0
    assert found.means[-1, 0] < 3 * found.means[5, 0] < 0


def test_spins_without_a_label_are_no_axis():
    shots = measured(count=20, labels=None)
    found = locate(fit_nuisance(shots, NOMINAL, NOISE, SETTINGS.fit), Question(NOMINAL), [])
    assert not {one.covariate for one in found.growth} & {"spin at launch", "spin axis"}
