"""Locate: shares point to the wrong phase, and trends to the right covariate."""

import numpy as np
import pytest

from models.gap.fit.noise import Noise
from models.gap.fit.refit import fit_nuisance
from models.gap.locate.attribution import locate
from models.gap.settings import Question
from models.gap.verify.prediction_error import errors
from tests.models.gap.hidden import NOMINAL, SETTINGS, measured

NOISE = Noise(white=0.003, slow=1e-5, label=0.05, label_common=1e-3, scatter=(0.01, 0.02, 0.005))
EXACT = Noise(white=1e-4, slow=1e-5, label=0.01, label_common=1e-3, scatter=(1e-3, 1e-3, 1e-3))


def located(truth, withheld=(), count=30, seed=1001):
    shots = measured(truth, count=count, seed=seed)
    fit = fit_nuisance(shots, NOMINAL, NOISE, SETTINGS.fit)
    return locate(fit, Question(NOMINAL, withheld=withheld))


@pytest.mark.parametrize(
    ("phase", "effect", "values"),
    [
        ("flight", "drag", {"cd": 0.53}),
        ("table", "table_bounce", {"restitution": 0.895}),
        ("sensor", "position_scale", {"s": 0.012}),
        pytest.param("table", "table_height", {"h": 0.004}, marks=pytest.mark.slow),
        pytest.param("sensor", "spin_gain", {"s": 0.1}, marks=pytest.mark.slow),
    ],
)
def test_the_share_points_to_the_phase_that_is_wrong(phase, effect, values):
    where = located(NOMINAL.amended(effect, **values)).phase_shares
    assert where[phase] > 0.9
    assert sum(where.values()) == pytest.approx(1.0)


def test_a_right_simulator_has_no_discrepancy():
    found = located(NOMINAL)
    assert found.phase_shares == {"flight": 0.0, "table": 0.0, "sensor": 0.0}
    assert not found.discrepancy.any()
    assert min(growth.p_value for growth in found.growth) > 0.01


@pytest.mark.slow
def test_a_phase_is_found_without_the_effect_in_the_catalogue():
    found = located(NOMINAL.amended("side_force", cy=0.02), ("side_force",))
    assert found.phase_shares["flight"] > 0.9


def test_a_wrong_table_counts_from_the_bounce_on():
    truth = NOMINAL.amended("wind", x=0.15).amended("table_bounce", restitution=0.895)
    shares = located(truth).shares
    assert shares["table"][1] < 0.1
    assert shares["table"][-1] > 0.2
    np.testing.assert_allclose(sum(shares.values()), 1.0)


def test_the_discrepancy_is_the_error_of_predictions_of_exact_shots():
    truth = NOMINAL.amended("drag", cd=0.45)
    shots = measured(truth, count=16, noise=1e-5, label=1e-3, scatter=(0.0, 0.0, 0.0))
    about = fit_nuisance(shots, truth, EXACT, SETTINGS.fit)
    found = locate(about, Question(NOMINAL))
    predicted = errors(about, (NOMINAL, truth), EXACT, (150.0, 150.0), SETTINGS)
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
    found = locate(fit_nuisance(shots, NOMINAL, NOISE, SETTINGS.fit), Question(NOMINAL))
    assert not {one.covariate for one in found.growth} & {"spin at launch", "spin axis"}
