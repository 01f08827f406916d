"""Tables of forecast errors at known errors."""

import numpy as np
import pytest

from rallygap.models.predictors.errors import HORIZONS_MS
from rallygap.models.predictors.evaluation import ForecastErrors

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


def test_kinds_of_window_are_distinguished():
    rows = errors(a=0.0).over_horizon().query("quantity == 'position' and horizon_ms == 200")
    mean = rows.set_index("bounce")["mean"]
    assert mean["all"] == pytest.approx(HARD.mean())
    assert mean["with"] == pytest.approx(HARD[::2].mean())
    assert mean["without"] == pytest.approx(HARD[1::2].mean())


def test_what_was_never_measured_has_no_row():
    one = errors(a=0.0)
    one.errors["a"]["spin"][:, 10:] = np.nan
    rows = one.over_horizon().query("bounce == 'all'").groupby("quantity").size()
    assert rows.to_dict() == {"position": HORIZONS, "velocity": HORIZONS, "spin": 10}


def test_one_more_predictor_changes_nothing_for_the_others():
    alone = errors(b=2.0).over_horizon()
    together = errors(a=0.0, b=2.0).over_horizon().query("predictor == 'b'").reset_index(drop=True)
    assert alone.equals(together)


def test_a_small_difference_shows_where_windows_differ_much():
    rows = errors(a=0.0, b=2.0).differences(["a"])
    np.testing.assert_allclose(rows[["mean", "ci_low", "ci_high"]], -2.0)
    assert (rows["lower_share"] == 1).all()
    assert list(rows["horizon_ms"].unique()) == [100, 200, 300]
    interval = errors(a=0.0).over_horizon().iloc[0]
    assert interval["ci_high"] - interval["ci_low"] > 10  # unpaired, it would be lost


def test_the_share_of_horizons_counts_those_at_which_the_mean_is_lower():
    one = errors(a=0.0, b=0.0)
    one.errors["a"]["velocity"][:, :10] -= 5.0
    one.errors["a"]["velocity"][:, 10:] += 5.0
    rows = one.differences(["a"]).query("quantity == 'velocity'")
    assert rows["lower_share"].unique() == [10 / HORIZONS]


def test_groups_have_the_error_of_their_recordings_at_the_last_horizon():
    groups = np.repeat(["pro", "club"], WINDOWS // 2)
    one = errors(a=0.0)
    one.errors["a"]["position"][:, :-1] = 0.0
    rows = one.by_group(groups).set_index("group")
    assert list(rows.index) == ["pro", "club"]
    assert rows.loc["pro", "mean"] == pytest.approx(HARD[:20].mean())
    assert rows.loc["club", "n"] == 20
