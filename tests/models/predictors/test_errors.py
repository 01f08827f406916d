"""Error statistics at known points."""

import numpy as np
import pytest

from rallygap.models.predictors.errors import error_norms, error_statistics
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


def test_the_error_is_the_norm_in_the_unit_of_the_quantity():
    windows = measured_windows()
    shift = np.array([0.003, 0, 0.004, 0, 3, 4, 5, 0, 12])
    for quantity, value in (("position", 5.0), ("velocity", 5.0), ("spin", 13.0)):
        np.testing.assert_allclose(error_norms(forecast(windows, shift), windows, quantity), value)


def test_unmeasured_states_do_not_count():
    windows = measured_windows()
    windows.measured[1, 30, 7] = False
    spin = error_norms(forecast(windows, 1.0), windows, "spin")
    assert np.isnan(spin[1, 30 - 19])
    assert np.isfinite(error_norms(forecast(windows), windows, "position")).all()
    result = error_statistics(spin, np.arange(4), 10, np.random.default_rng(0))
    assert result.count[30 - 19] == 3


def test_mean_and_spread_of_known_errors():
    error = np.repeat([[1.0], [2.0], [3.0], [6.0]], 41, axis=1)
    result = error_statistics(error, np.arange(4), 200, np.random.default_rng(0))
    np.testing.assert_allclose(result.mean, 3.0)
    np.testing.assert_allclose(result.median, 2.5)
    np.testing.assert_allclose(result.std, np.std([1, 2, 3, 6]))
    assert (result.low < 3.0).all()
    assert (result.high > 3.0).all()


def test_the_interval_covers_the_truth_nineteen_times_in_twenty():
    generator = np.random.default_rng(5)
    hits = []
    for _ in range(300):
        centres = np.repeat(generator.normal(0, 1, 40), 5)  # windows of a recording move together
        error = (10 + centres + generator.normal(0, 0.3, 200))[:, None]
        result = error_statistics(error, np.repeat(np.arange(40), 5), 300, generator)
        hits.append(result.low[0] <= 10 <= result.high[0])
    assert 0.90 < np.mean(hits) < 0.98


@pytest.mark.parametrize("windows", [4, 0])
def test_errors_without_a_measurement_have_no_mean(windows):
    unmeasured = measured_windows(windows, measured=False)
    errors = error_norms(forecast(unmeasured), unmeasured, "spin")
    result = error_statistics(errors, np.arange(windows), 5, np.random.default_rng(0))
    assert np.isnan([result.mean, result.low, result.high]).all()
    assert (result.count == 0).all()
