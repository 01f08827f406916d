"""Each claim of the paper is judged from the table that it is about."""

import pytest

from pipeline.paper import values as paper
from pipeline.paper.catalogue import EXHIBITS
from pipeline.paper.judgements import (
    FAILS,
    HIGHER,
    HOLDS,
    LEVEL,
    LOWER,
    NOT_MEASURED,
    OPEN,
)
from pipeline.paper.prediction_accuracy import ACCURACY, BESIDE_OTHERS, OTHERS, QUANTITIES, RIVALS
from pipeline.paper.shot_quality import DOUBLED, QUALITY
from pipeline.paper.transfer import COUNTS, ESPECIALLY, GAINS, SIM2SIM
from tests.pipeline.paper.written import differences, errors, swap, write


def found(group, run, key):
    return next(entry for entry in group.entries if entry.key == key).find(run)


def accuracy(root, key="accuracy.position.physics_c", spread=None, **changes):
    write(root, "evaluate_predictor/forecast_error.csv", errors(spread))
    table = "evaluate_predictor/forecast_error_difference.csv"
    return found(ACCURACY, write(root, table, differences(**changes)), key)


@pytest.mark.parametrize(
    ("changes", "word"),
    [({}, HOLDS), ({"half": 25.0}, OPEN), ({"mean": 20.0}, FAILS), ({"lower_share": 0.9}, OPEN)],
)
def test_the_transformer_is_the_best_where_it_is_so_at_every_horizon(tmp_path, changes, word):
    assert accuracy(tmp_path, **changes).verdict == word


def test_its_error_is_shown_in_percent_of_the_other_s(tmp_path):
    shown = accuracy(tmp_path).interval
    assert shown == pytest.approx((-50.0, -62.5, -37.5))


def test_pairs_are_found_in_either_order(tmp_path):
    other_way = accuracy(
        tmp_path, predictor="physics_c", other="transformer", mean=20.0, lower_share=0.0
    )
    assert other_way.verdict == HOLDS
    assert other_way.interval == pytest.approx((-50.0, -62.5, -37.5))


def test_a_rival_that_was_not_evaluated_is_not_measured(tmp_path):
    assert accuracy(tmp_path, "accuracy.spin.gru_tae").verdict == NOT_MEASURED


def test_errors_spread_least_beside_all_but_the_oracle(tmp_path):
    key = "accuracy.spin.spread"
    least = accuracy(tmp_path, key, {"oracle": 1.0, "tae": 25.0})
    assert least.verdict == HOLDS
    assert least.value == pytest.approx(100 * (10 / 25 - 1))  # % of the least of the others
    assert accuracy(tmp_path, key, {"tae": 9.0}).verdict == FAILS


def test_the_paper_s_figure_is_judged_without_our_own_contenders(tmp_path):
    ahead = [row for rival in RIVALS for row in differences(other=rival)]
    behind = [row for rival in OTHERS for row in differences(other=rival, mean=20.0)]
    write(tmp_path, "evaluate_predictor/forecast_error.csv", errors())
    run = write(tmp_path, "evaluate_predictor/forecast_error_difference.csv", ahead + behind)
    figure = next(one for one in EXHIBITS if one.name == "Figure 3")
    assert figure.verdict(run) == HOLDS
    assert {entry.find(run).verdict for entry in BESIDE_OTHERS.entries} == {FAILS}
    assert len(BESIDE_OTHERS.entries) == len(OTHERS) * len(QUANTITIES)


def test_sim_to_sim_is_judged_from_the_first_state(tmp_path):
    row = {"simulator": "imperfect_b", "horizons_ms": "170-180"}
    first = {"protocol": "first_state", "difference": 0.2, "ci_low": 0.1, "ci_high": 0.3}
    anew = {"protocol": "re_anchored", "difference": -0.2, "ci_low": -0.3, "ci_high": -0.1}
    run = write(tmp_path, "sim2sim/difference.csv", [{**row, **anew}, {**row, **first}])
    gain = found(SIM2SIM, run, "sim2sim.imperfect_b.170-180")
    assert gain.verdict == HOLDS and gain.interval == pytest.approx((20, 10, 30))
    assert found(SIM2SIM, run, "sim2sim.imperfect_a.170-180").verdict == NOT_MEASURED


@pytest.mark.parametrize(("hits", "word"), [(30, LOWER), (41, LEVEL), (56, HIGHER)])
def test_counts_are_compared_as_shares(tmp_path, hits, word):
    row = {
        "set": "stroke_pro", "horizons_ms": "115-125", "predictor": "physics",
        "protocol": "every_tick", "balls": 60, "hits": hits, "hit_rate": hits / 60,
        "hit_rate_low": hits / 60 - 0.1, "hit_rate_high": hits / 60 + 0.1,
    }  # fmt: skip
    run = write(tmp_path, "sim2real/rates.csv", [row])
    assert found(COUNTS, run, "transfer.stroke_pro.115-125.physics.hits").verdict == word
    assert found(COUNTS, run, "transfer.stroke_pro.170-180.physics.hits").verdict == NOT_MEASURED


def test_gains_of_the_paper_are_those_of_its_table():
    printed = {entry.key: entry.printed for entry in GAINS.entries}
    assert len(printed) == 2 * len(paper.TRANSFER)
    assert printed["gain.stroke_uni.115-125.returns"] == 100 * (146 - 80) / 200
    assert printed["gain.receive.115-125.hits"] == 0


def gained(name, points, half=0.01):
    return {
        "set": name, "horizons_ms": "115-125", "predictor": "transformer", "outcome": "returns",
        "protocol": "every_tick", "difference": points, "ci_low": points - half,
        "ci_high": points + half,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("uni", "half", "word"), [(0.3, 0.01, HOLDS), (0.1, 0.01, FAILS), (0.3, 0.2, OPEN)]
)
def test_the_swap_gains_the_most_in_strokes_of_universities(tmp_path, uni, half, word):
    rows = [gained("stroke_uni", uni, half), gained("stroke_pro", 0.2, half)]
    run = write(tmp_path, "sim2real/difference.csv", rows)
    more = found(ESPECIALLY, run, "most.stroke_pro.115-125.returns")
    assert more.verdict == word and more.value == pytest.approx(100 * (uni - 0.2))
    assert found(ESPECIALLY, run, "most.receive.115-125.returns").verdict == NOT_MEASURED


def test_the_paper_s_own_gains_are_the_largest_in_strokes_of_universities():
    printed = {entry.key: entry.printed for entry in ESPECIALLY.entries}
    assert printed["most.receive.115-125.returns"] == 100 * (146 - 80) / 200 - (76 - 68)
    assert min(printed.values()) == 0 and sum(value > 0 for value in printed.values()) == 7


def test_returns_get_faster_and_flatter(tmp_path):
    run = write(tmp_path, "shot_quality/swap.csv", swap(times=1.25))
    faster = found(QUALITY, run, "quality.speed.receive.115-125")
    assert faster.verdict == HOLDS and faster.value == pytest.approx(25.0)
    assert found(QUALITY, run, "quality.clearance.receive.115-125").verdict == FAILS
    vague = write(tmp_path, "shot_quality/swap.csv", swap(half=0.3))
    assert found(QUALITY, vague, "quality.speed.receive.115-125").verdict == OPEN


@pytest.mark.parametrize(
    ("times", "half", "word"),
    [(2.0, 0.1, HOLDS), (1.05, 0.05, FAILS), (3, 0.1, FAILS), (2, 1.5, OPEN), (1.55, 0.1, OPEN)],
)
def test_twice_is_about_twice_as_a_whole(tmp_path, times, half, word):
    run = write(tmp_path, "shot_quality/swap.csv", swap(times, half))
    twice = found(DOUBLED, run, "quality.doubled.stroke_pro")
    assert twice.verdict == word
    assert twice.interval == pytest.approx((times, times - half, times + half))


def test_a_median_of_nothing_is_doubled_by_none(tmp_path):
    run = write(tmp_path, "shot_quality/swap.csv", swap(times=float("nan")))
    assert found(DOUBLED, run, "quality.doubled.stroke_pro").verdict == NOT_MEASURED
