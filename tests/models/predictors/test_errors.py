"""Statistics and tables of known forecast errors."""

import numpy as np
import pytest

from rallygap.models.predictors.errors import HORIZONS_MS, error_norms, error_statistics
from rallygap.models.predictors.evaluation import ForecastErrors
from rallygap.models.predictors.protocol import Forecast, History
from rallygap.models.predictors.windows import Windows


def measured_windows(count=4, measured=True):
    future = np.random.default_rng(1).normal(size=(count, 60, 9))
    mask = np.full(future.shape, measured)
    history = History(np.zeros((count, 12, 6)), np.zeros((count, 12, 6), dtype=bool))
    bounced = np.zeros((count, 60), dtype=bool)
    return Windows(history, np.zeros(count), future, mask, bounced)


def forecast(windows, shift=0.0):
    return Forecast(windows.future + shift, np.zeros(len(windows), dtype=bool))


def test_the_error_is_the_norm_in_the_unit_of_the_quantity_where_it_was_measured():
    windows = measured_windows()
    shift = np.array([0.003, 0, 0.004, 0, 3, 4, 5, 0, 12])
    for quantity, value in (("position", 5.0), ("velocity", 5.0), ("spin", 13.0)):
        np.testing.assert_allclose(error_norms(forecast(windows, shift), windows, quantity), value)
    windows.measured[1, 30, 7] = False
    spin = error_norms(forecast(windows, 1.0), windows, "spin")
    assert np.isnan(spin[1, 30 - 19]) and np.isnan(spin).sum() == 1


def test_statistics_are_those_of_the_windows_with_a_measurement():
    error = np.repeat([[1.0], [2.0], [np.nan], [3.0], [6.0]], 41, axis=1)
    result = error_statistics(error, np.arange(5), 200, np.random.default_rng(0))
    expected = np.tile([[4], [3.0], [2.5], [np.std([1, 2, 3, 6])]], 41)
    np.testing.assert_allclose([result.count, result.mean, result.median, result.std], expected)


def test_the_interval_covers_the_truth_nineteen_times_in_twenty():
    generator = np.random.default_rng(5)
    hits = []
    for _ in range(200):
        centres = np.repeat(generator.normal(0, 1, 40), 5)  # windows of a recording move together
        error = (10 + centres + generator.normal(0, 0.3, 200))[:, None]
        result = error_statistics(error, np.repeat(np.arange(40), 5), 200, generator)
        hits.append(result.low[0] <= 10 <= result.high[0])
    assert 0.89 < np.mean(hits) < 0.99


@pytest.mark.parametrize("windows", [4, 0])
def test_errors_without_a_measurement_have_no_mean(windows):
    unmeasured = measured_windows(windows, measured=False)
    errors = error_norms(forecast(unmeasured), unmeasured, "spin")
    result = error_statistics(errors, np.arange(windows), 5, np.random.default_rng(0))
    assert np.isnan([result.mean, result.low, result.high]).all()
    assert (result.count == 0).all()


WINDOWS = 40
HORIZONS = len(HORIZONS_MS)
RECORDINGS = np.repeat([f"arena/{group}/{k}" for group in ("pro", "club") for k in range(5)], 4)
HARD = np.random.default_rng(3).uniform(10, 100, (WINDOWS, 1))  # the same for every predictor


def errors(**offsets):
    """Errors of predictors that differ by a fixed amount on windows that differ much more."""
    made = {
        name: {
            quantity: np.repeat(HARD + offset, HORIZONS, axis=1)
            for quantity in ("position", "velocity", "spin")
        }
        for name, offset in offsets.items()
    }
    bounced = np.arange(WINDOWS) % 2 == 0
    return ForecastErrors(made, RECORDINGS, bounced, resamples=200, seed=1)


def test_kinds_of_window_are_distinguished_and_what_was_never_measured_has_no_row():
    some = errors(a=0.0)
    some.errors["a"]["spin"][:, 10:] = np.nan
    table = some.over_horizon()
    rows = table.query("quantity == 'position' and horizon_ms == 200")
    expected = {"all": HARD.mean(), "with": HARD[::2].mean(), "without": HARD[1::2].mean()}
    assert rows.set_index("bounce")["mean"].to_dict() == pytest.approx(expected)
    counts = table.query("bounce == 'all'").groupby("quantity").size()
    assert counts.to_dict() == {"position": HORIZONS, "velocity": HORIZONS, "spin": 10}


def test_a_small_difference_shows_where_windows_differ_much():
    some = errors(a=0.0, b=2.0)
    some.errors["a"]["velocity"][:, 10:] += 5.0
    table = some.differences(["a"])
    rows = table.query("quantity != 'velocity'")
    np.testing.assert_allclose(rows[["mean", "ci_low", "ci_high"]], -2.0)
    assert (rows["lower_share"] == 1).all()
    assert set(table.query("quantity == 'velocity'")["lower_share"]) == {10 / HORIZONS}
    assert list(rows["horizon_ms"].unique()) == [100, 200, 300]
    interval = errors(a=0.0).over_horizon().iloc[0]
    assert interval["ci_high"] - interval["ci_low"] > 10  # unpaired, it would be lost
