"""Sections of the report page: what they say, and the drawn arm."""

import numpy as np
import pandas as pd
import pytest

from rallygap.models.robot.constants import BLADE, FOREARM, JOINTS, LOWER, UPPER, UPPER_ARM
from rallygap.models.robot.kinematics import racket
from rallygap.pipeline.io.artifacts import write_csv
from rallygap.pipeline.paper.assessments import NOT_DIFFERENT, Finding, Interval
from rallygap.pipeline.paper.comparison import Group, groups
from rallygap.pipeline.paper.run_reports import Reports
from rallygap.pipeline.paper.values import Value
from rallygap.pipeline.report.paper import mark, paper_section
from rallygap.pipeline.report.results import RESULTS, results_section
from rallygap.pipeline.report.scenes import arm_lines

GAP = {"source": "arena", "simulator": "imperfect_c", "before_mm": 80.4, "after_mm": 30.2}
FORECAST = {"set": "tt3d", "quantity": "position", "bounce": "all", "horizon_ms": 300}
EXAM = {
    "distinguishable_right": 7, "distinguishable": 8, "pairs_right": 2, "pairs": 3,
    "false_alarms": 0, "clean_sets": 9,
}  # fmt: skip


@pytest.fixture
def run(tmp_path):
    """Reports with numbers for every result but the learning curves."""
    policies = pd.DataFrame({"predictor": ["physics_c", "transformer", "amended"]})
    policies = policies.assign(observation="intercept", horizons_ms="115-125")
    for column, shift in (("rate", 0.0), ("rate_low", -0.1), ("rate_high", 0.1)):
        policies[f"return_{column}"] = shift + np.array([0.4, 0.5, 0.6])
    protocols = ("first_window", "every_tick")
    tables = {
        "swap_study/readings_all.csv": pd.concat(
            [policies.assign(protocol=protocol) for protocol in protocols]
        ),
        "exam/rates.csv": [{"rate": name, "rallygap": count} for name, count in EXAM.items()],
        "close_gap/errors.csv": [{**GAP, "horizon_ms": 300, "floor_mm": 29.0}],
        "real_forecasts/errors.csv": [
            {**FORECAST, "predictor": "physics_literature", "mean": 100.2},
            {**FORECAST, "predictor": "hybrid_ensemble", "mean": 60.1},
        ],
    }
    for name, rows in tables.items():
        write_csv(tmp_path / name, pd.DataFrame(rows))
    return Reports(tmp_path, {})


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("swap", "40, 50 and 60 % with a forecast at every control step (95 % intervals: at most"),
        ("gap", "simulator C on held-out shots of the arena, 300 ms ahead, is 80 mm before and 30"),
        ("real", "tt3d 100 to 60 mm"),
        ("exam", "7 of 8 distinguishable hidden effects of three detection limits are named"),
    ],
)
def test_a_result_says_what_the_reports_have(run, key, words):
    _, sentence, _ = RESULTS[key]
    assert words in sentence(run)


def test_results_that_lack_a_number_are_left_out(run):
    figures = {figure for _, _, figure in RESULTS.values()}
    for figure in figures:
        (run.folder / figure).parent.mkdir(parents=True, exist_ok=True)
        (run.folder / figure).write_bytes(b"\x89PNG\r\n\x1a\n")
    (run.folder / "swap_study/readings_all.csv").unlink()
    write_csv(run.folder / "exam/rates.csv", pd.DataFrame([{"rate": "pairs", "rallygap": 3}]))
    assert [one["key"] for one in results_section(run, figures)] == ["gap", "real"]


VALUE = Value("group", "id", "what", rule="more", value=50.0, ours="file")


def test_values_are_drawn_inside_their_axis():
    found = Finding(NOT_DIFFERENT, 0.0, Interval(0.0, -40.0, 150.0))
    drawn = mark(Group("id", "title", axis=(-100.0, 100.0)), VALUE, found)
    assert (drawn.zero, drawn.paper, drawn.ours) == (50.0, 75.0, 50.0)
    assert (drawn.low, drawn.high) == (30.0, 100.0)


@pytest.mark.parametrize(
    ("ours", "place"),
    [(50.0, 50.0), (5.0, 25.0), (5e-9, 0.0), (5e5, 100.0), ("half a cosine", None)],
)
def test_sizes_are_drawn_by_their_ratio(ours, place):
    assert mark(Group("id", "title"), VALUE, Finding(NOT_DIFFERENT, ours)).ours == place


def test_every_value_is_shown_and_files_on_the_page_are_linked(tmp_path):
    file = "shot_quality/quality.csv"
    shown = paper_section(Reports(tmp_path, {}), {file, "sim2real"})
    assert [len(one["rows"]) for one in shown["groups"]] == [len(one.values) for one in groups()]
    parts = {part: anchor for one in shown["exhibits"] for part, anchor in one["ours"] if anchor}
    assert parts == {file: file}


POSES = np.random.default_rng(0).uniform(LOWER, UPPER, size=(20, len(JOINTS)))


def test_the_racket_is_where_the_kinematics_have_it_and_links_keep_their_lengths():
    points, normals = arm_lines(POSES)
    expected = racket(POSES, np.zeros_like(POSES))
    assert points[:, -1] == pytest.approx(expected.position, abs=1e-12)
    assert normals == pytest.approx(expected.normal, abs=1e-12)
    lengths = np.linalg.norm(np.diff(points, axis=1), axis=2)
    links = [UPPER_ARM, FOREARM, np.linalg.norm(BLADE)]
    assert lengths == pytest.approx(np.tile(links, (len(POSES), 1)))
