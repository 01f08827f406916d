"""Each value of the paper is compared with the number that it is about, and assessed by rule."""

import itertools

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.paper.assessments import (
    DIFFERS,
    FAILS,
    HIGHER,
    HOLDS,
    LOWER,
    NO_NUMBER,
    NOT_COMPARABLE,
    NOT_DIFFERENT,
    NOT_MEASURED,
    OPEN,
    SAME,
    Interval,
    combined,
    difference,
    rate,
    setting,
    within,
)
from rallygap.pipeline.paper.comparison import compare, exhibits
from rallygap.pipeline.paper.run_reports import Reports
from rallygap.pipeline.paper.values import printed_transfer, printed_values
from rallygap.pipeline.runtime.errors import InputError

VALUES = {value.id: value for value in printed_values()}
RIVALS = ("physics_c", "physics_literature", "tae", "gru_tae", "amended_imperfect_c", "oracle")
QUANTITIES = ("position", "velocity", "spin")
HORIZONS_MS = (100, 200, 300)


def write(root, file, rows):
    """Write a table of the reports; return them."""
    path = root / "reports" / file
    path.parent.mkdir(parents=True, exist_ok=True)
    pd.DataFrame(rows).to_csv(path, index=False)
    return Reports(root / "reports", {})


def write_errors(root, spread=None, **changes):
    """Write mean errors of 20 (transformer) and 40 (others), and their differences."""
    spread = {"transformer": 10.0} | (spread or {})
    keys = itertools.product(["transformer", *RIVALS], QUANTITIES, HORIZONS_MS)
    errors = pd.DataFrame(keys, columns=["predictor", "quantity", "horizon_ms"])
    errors = errors.assign(set="arena", against="measured", bounce="all", mean=40)
    errors.loc[errors["predictor"] == "transformer", "mean"] = 20
    errors["std"] = errors["predictor"].map(spread).fillna(30.0)
    write(root, "evaluate_predictor/forecast_error.csv", errors)
    file = "evaluate_predictor/forecast_error_difference.csv"
    return write(root, file, differences(**changes))


def differences(predictor="transformer", other="physics_c", mean=-20.0, half=5.0, lower_share=1.0):
    keys = itertools.product(QUANTITIES, HORIZONS_MS)
    rows = pd.DataFrame(keys, columns=["quantity", "horizon_ms"])
    rows = rows.assign(set="arena", predictor=predictor, other=other, lower_share=lower_share)
    return rows.assign(mean=mean, ci_low=mean - half, ci_high=mean + half)


def with_ends(names, value, half):
    """The columns of numbers with their intervals, all alike."""
    ends = {f"{name}_low": value - half for name in names}
    return dict.fromkeys(names, value) | ends | {f"{name}_high": value + half for name in names}


def gain(value, half, **keys):
    """A row of a table of differences, of returns at 115-125 ms where keys do not say else."""
    keys = {"horizons_ms": "115-125", "predictor": "transformer", "outcome": "returns"} | keys
    ends = {"ci_low": value - half, "ci_high": value + half}
    return {"protocol": "every_tick", **keys, "difference": value, **ends}


SWAPPED = {"predictor": "physics_c", "other": "transformer", "mean": 20.0, "lower_share": 0.0}


@pytest.mark.parametrize(
    ("changes", "word", "percent"),
    [
        ({}, HOLDS, (-50.0, -62.5, -37.5)),
        (SWAPPED, HOLDS, (-50.0, -62.5, -37.5)),
        ({"half": 25.0}, OPEN, (-50.0, -112.5, 12.5)),
        ({"mean": 20.0}, FAILS, (50.0, 37.5, 62.5)),
        ({"lower_share": 0.9}, OPEN, (-50.0, -62.5, -37.5)),
    ],
)
def test_a_forecast_error_is_smaller_only_if_it_is_at_every_horizon(
    tmp_path, changes, word, percent
):
    found = compare(write_errors(tmp_path, **changes))
    assert found["accuracy.position.physics_c"].assessment == word
    assert found["accuracy.position.physics_c"].interval == pytest.approx(percent)
    assert found["accuracy.spin.gru_tae"].assessment == NOT_MEASURED


def test_the_spread_is_compared_with_the_papers_predictors_alone(tmp_path):
    found = compare(write_errors(tmp_path, {"oracle": 1.0, "tae": 25.0}))["accuracy.spin.spread"]
    assert found.assessment == HOLDS
    assert found.value == pytest.approx(100 * (10 / 25 - 1))  # % of the smallest rival
    found = compare(write_errors(tmp_path, {"tae": 9.0}))["accuracy.spin.spread"]
    assert found.assessment == FAILS


def test_figure_3_is_judged_without_the_contenders_that_the_paper_lacks(tmp_path):
    means = dict.fromkeys(RIVALS[:4], -20.0) | dict.fromkeys(RIVALS[4:], 20.0)
    write_errors(tmp_path)
    file = "evaluate_predictor/forecast_error_difference.csv"
    rows = pd.concat([differences(other=rival, mean=mean) for rival, mean in means.items()])
    run = write(tmp_path, file, rows)
    assert next(one for one in exhibits() if one.name == "Figure 3").assessment(run) == HOLDS
    found = compare(run)
    assert {found[f"accuracy.{name}.oracle"].assessment for name in QUANTITIES} == {FAILS}


def test_sim_to_sim_is_judged_from_the_first_state(tmp_path):
    keys = {"simulator": "imperfect_b", "horizons_ms": "170-180"}
    later = gain(-0.2, 0.1, **keys, protocol="re_anchored")
    first = gain(0.2, 0.1, **keys, protocol="first_state")
    found = compare(write(tmp_path, "sim2sim/difference.csv", [later, first]))
    more = found["sim2sim.imperfect_b.170-180"]
    assert more.assessment == HOLDS and more.interval == pytest.approx((20, 10, 30))
    assert found["sim2sim.imperfect_a.170-180"].assessment == NOT_MEASURED
    with pytest.raises(InputError, match="2 rows"):
        compare(write(tmp_path, "sim2sim/difference.csv", [first, first]))


@pytest.mark.parametrize(("hits", "word"), [(30, LOWER), (41, NOT_DIFFERENT), (56, HIGHER)])
@pytest.mark.parametrize(
    ("protocol", "key"), [("every_tick", "physics"), ("first_window", "physics_first_window")]
)
def test_counts_are_compared_as_rates(tmp_path, hits, word, protocol, key):
    row = {
        "set": "stroke_pro", "horizons_ms": "115-125", "predictor": "physics",
        "protocol": protocol, "balls": 60, "hits": hits, **with_ends(["hit_rate"], hits / 60, 0.1),
    }  # fmt: skip
    found = compare(write(tmp_path, "sim2real/rates.csv", [row]))
    assert found[f"transfer.stroke_pro.115-125.{key}.hits"].assessment == word
    assert found[f"transfer.stroke_pro.170-180.{key}.hits"].assessment == NOT_MEASURED


def test_printed_gains_are_the_differences_of_the_printed_counts():
    gained = {}
    for name, (shots, counts) in printed_transfer().items():
        for horizons, by_predictor in counts.items():
            for outcome in ("hits", "returns"):
                change = by_predictor["learned"][outcome] - by_predictor["physics"][outcome]
                gained[name, horizons, outcome] = 100 * change / shots
    for reading in ("", "_first_window"):
        for (name, horizons, outcome), gain in gained.items():
            assert VALUES[f"gain{reading}.{name}.{horizons}.{outcome}"].printed == gain
            if name != "stroke_uni":
                more = gained["stroke_uni", horizons, outcome] - gain
                assert VALUES[f"most{reading}.{name}.{horizons}.{outcome}"].printed == more


@pytest.mark.parametrize(
    ("uni", "half", "word"), [(0.3, 0.01, HOLDS), (0.1, 0.01, FAILS), (0.3, 0.2, OPEN)]
)
def test_the_largest_gain_is_judged_between_independent_sets(tmp_path, uni, half, word):
    rows = [gain(uni, half, set="stroke_uni"), gain(0.2, half, set="stroke_pro")]
    found = compare(write(tmp_path, "sim2real/difference.csv", rows))
    more = found["most.stroke_pro.115-125.returns"]
    assert more.assessment == word and more.value == pytest.approx(100 * (uni - 0.2))
    assert found["most.receive.115-125.returns"].assessment == NOT_MEASURED
    found = compare(write(tmp_path, "sim2real/difference_first_window.csv", rows))
    own = found["gain_first_window.stroke_pro.115-125.returns"].interval
    assert own == pytest.approx((20, 100 * (0.2 - half), 100 * (0.2 + half)))


ASKED = {"train_policy": {"groups": {"sim2sim": {"goals": {"speed": [4.5, 6.5]}}}}}


@pytest.mark.parametrize(
    ("params", "times", "faster", "doubled"),
    [
        ({}, 1.25, NOT_COMPARABLE, NOT_COMPARABLE),
        (ASKED, 1.25, HOLDS, FAILS),
        (ASKED, float("nan"), NOT_MEASURED, NOT_MEASURED),
    ],
)
def test_shot_quality_is_comparable_where_policies_are_asked_for_speed(
    tmp_path, params, times, faster, doubled
):
    keys = {"set": "stroke_pro", "horizons_ms": "115-125", "predictor": "transformer"}
    ratios = with_ends(["speed", "spin", "clearance", "win_probability"], times, 0.05)
    row = {**keys, "protocol": "every_tick", **ratios}
    folder = write(tmp_path, "shot_quality/swap.csv", [row]).folder
    found = compare(Reports(folder, params))
    speed, winning = found["quality.speed.stroke_pro.115-125"], found["quality.doubled.stroke_pro"]
    assert (speed.assessment, winning.assessment) == (faster, doubled)
    if times == 1.25:
        assert speed.value == pytest.approx(25.0)
        assert winning.interval == pytest.approx((1.25, 1.2, 1.3))


def test_without_reports_only_constants_have_an_assessment(tmp_path):
    run = Reports(tmp_path, {})
    words = {found.assessment for found in compare(run).values()}
    assert words == {NOT_MEASURED, NO_NUMBER, SAME, DIFFERS}
    assert {one.assessment(run) for one in exhibits()} == {NOT_MEASURED, NO_NUMBER}


@pytest.mark.parametrize(
    ("parts", "word"),
    [
        ([HOLDS, HOLDS], HOLDS),
        ([HOLDS, OPEN], OPEN),
        ([HOLDS, OPEN, NOT_MEASURED], NOT_MEASURED),
        ([HOLDS, NOT_MEASURED, FAILS], FAILS),
        ([], NOT_MEASURED),
    ],
)
def test_a_figure_fails_with_one_claim_and_is_not_measured_without_one(parts, word):
    assert combined(parts) == word


def test_intervals_of_a_difference_of_rates_cover_95_percent():
    random = np.random.default_rng(0)
    counts = random.binomial(60, 0.8, 2000), random.binomial(60, 0.7, 2000)
    rates = {count: rate(count, 60) for count in range(61)}
    found = [difference(rates[a], rates[b]) for a, b in zip(*counts, strict=True)]
    assert 0.93 < np.mean([one.low <= 0.1 <= one.high for one in found]) < 0.97


@pytest.mark.parametrize(
    ("low", "high", "word"),
    [(1.6, 2.4, HOLDS), (1.4, 2.4, OPEN), (1.0, 3.0, OPEN), (0.9, 1.1, FAILS), (2.6, 3.0, FAILS)],
)
def test_a_range_holds_where_the_whole_interval_lies_inside(low, high, word):
    assert within(Interval((low + high) / 2, low, high), 1.5, 2.5) == word


@pytest.mark.parametrize(
    ("ours", "printed", "minimum", "word"),
    [
        (112_975, 100_000, True, SAME),
        (98_000, 100_000, True, DIFFERS),
        (0.901, 0.9, False, SAME),
        (0.92, 0.9, False, DIFFERS),
        ("Adam", "Adam", False, SAME),
        ("half a cosine", 0.95, False, DIFFERS),
    ],
)
def test_settings_are_the_same_to_one_percent_and_a_minimum_may_be_exceeded(
    ours, printed, minimum, word
):
    assert setting(ours, printed, minimum=minimum) == word
