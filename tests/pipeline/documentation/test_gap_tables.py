"""Tables of the exam count what its results say."""

import json

import pandas as pd
import pytest

from rallygap.pipeline.documentation.gap_tables import (
    ROBUSTNESS_RATES,
    arena_causes,
    arena_verdict,
    exam_rates,
    real_causes,
    real_errors,
    real_stability,
    real_summary,
    robustness_rates,
)
from rallygap.pipeline.io.artifacts import write_csv

CASE = {"source": ["tt3d"], "simulator": ["imperfect_c"], "split": [0]}
SIZES = {"before_mm": [9.0] * 3, "after_mm": [5.0] * 3, "floor_mm": [4.0] * 3}


def write_real(root, cause):
    """Write the tables of one verdict on a measured set."""
    folder = root / "reports/real/close_gap"
    folder.mkdir(parents=True)
    interval = {"reduction_low_mm": [1.0], "reduction_high_mm": [3.0]}
    landing = {f"landing_{name}": sizes[:1] for name, sizes in SIZES.items()}
    verdicts = pd.DataFrame({**CASE, "verdict": ["named"], **interval, **landing})
    verdicts.to_csv(folder / "verdicts.csv", index=False)
    rows = pd.DataFrame({name: value * 3 for name, value in CASE.items()})
    rows.assign(horizon_ms=[100, 200, 300], **SIZES).to_csv(folder / "errors.csv", index=False)
    found = [1] if cause else [None]
    stability = pd.DataFrame({**CASE, "cause": [cause], "found": found, "splits": [1]})
    stability.drop(columns="split").to_csv(folder / "stability.csv", index=False)


def write_exam(root, first, other):
    path = root / "reports/hidden_effects/exam.json"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps({**first, "compared": {"sindy": other}}))


def test_parameters_are_shown_that_are_hidden_or_named(tmp_path):
    columns = ["effect", "parameter", "original", "amended", "truth", "low", "high"]
    none = float("nan")
    rows = [
        ["drag", "cd", 0.4, 0.55, 0.551, 0.54, 0.56],  # wrong, and named
        ["wind", "x", none, none, 0.1, none, none],  # hidden, and not named
        ["spin_decay", "c", none, 0.2, none, 0.1, 0.3],  # named, and not hidden
        ["gravity", "g", 9.81, 9.81, 9.81, none, none],
        ["racket_bounce", "kp", 0.1, 0.1, 0.2, none, none],
        ["camera_distortion", "amplitude", none, 0.002, none, 0.001, 0.003],
    ]
    numbers = pd.DataFrame(rows, columns=columns).assign(source="arena")
    write_csv(tmp_path / "reports/run/retrain_policy/numbers.csv", numbers)
    assert arena_causes(tmp_path, "run/").splitlines()[2:] == [
        "| `drag.cd` | 0.4 | 0.55 (0.54 to 0.56) | 0.551 |",
        "| `wind.x` | – | – | 0.1 |",
        "| `spin_decay.c` | – | 0.2 (0.1 to 0.3) | – |",
        "| `camera_distortion.amplitude` | – | 0.002 (0.001 to 0.003) | camera field |",
    ]


def test_causes_of_a_single_split_are_left_out(tmp_path):
    one = {"source": "tt3d", "simulator": "imperfect_c", "splits": 3, "unit": "m/s"}
    causes = [
        {**one, "cause": "wind.x", "found": 2, "lowest": 0.1234, "highest": 0.5},
        {**one, "cause": "wind.y", "found": 1, "lowest": 0.1, "highest": 0.1},
        {**one, "cause": "drag.cd", "found": 3, "lowest": 0.5, "highest": 0.6, "unit": "1"},
    ]
    write_csv(tmp_path / "reports/real/close_gap/stability.csv", pd.DataFrame(causes))
    assert real_causes(tmp_path).splitlines()[2:] == [
        "| tt3d | simulator C | `wind.x` | 2 of 3 | 0.123 to 0.5 m/s |",
        "| tt3d | simulator C | `drag.cd` | 3 of 3 | 0.5 to 0.6 |",
    ]


@pytest.mark.parametrize(
    ("possible", "sentence"),
    [
        (["drag.cd", "wind.x"], "The verdict is `named`"),
        (
            ["drag.cd, linear_drag.c, wind.y", "net.friction"],
            "The verdict is `named` (`drag.cd` may be `linear_drag.c` or `wind.y`)",
        ),
    ],
)
def test_causes_that_shots_cannot_tell_apart_are_named(tmp_path, possible, sentence):
    folder = tmp_path / "reports/close_gap"
    case = {"source": "arena", "simulator": "imperfect_c"}
    verdicts = [{**case, "split": k, "verdict": one} for k, one in enumerate(("named", "unknown"))]
    write_csv(folder / "verdicts.csv", pd.DataFrame(verdicts))
    causes = [
        *({**case, "split": 0, "role": "leading", "possible": one} for one in possible),
        {**case, "split": 0, "role": "minor", "possible": "a.b, c.d"},
        {**case, "split": 1, "role": "leading", "possible": "e.f, g.h"},
    ]
    write_csv(folder / "causes.csv", pd.DataFrame(causes))
    assert arena_verdict(tmp_path) == sentence


def test_a_verdict_without_errors_at_a_horizon_has_a_dash(tmp_path):
    write_real(tmp_path, None)
    errors = tmp_path / "reports/real/close_gap/errors.csv"
    write_csv(errors, pd.read_csv(errors).query("horizon_ms < 300"))
    assert "9 → 5 (4) | 9 → 5 (4) | – |" in real_summary(tmp_path)


def test_a_method_without_records_of_a_rate_has_a_dash(tmp_path):
    asked = {"removable_closed": 0.923, "pairs": 77, "pairs_right": 74}
    write_exam(tmp_path, asked, {"removable_closed": None, "pairs": 0, "pairs_right": 0})
    rows = exam_rates(tmp_path).splitlines()
    assert "| two causes: both named | 74 of 77 | – |" in rows
    assert "| removable gap closed (%) | 92 | – |" in rows


def test_rates_of_robustness_groups_have_their_counts(tmp_path):
    write_exam(
        tmp_path,
        {"clean_sets_new": 120, "false_leading": 2},
        {"clean_sets_new": 0, "false_leading": 0},
    )
    head, _, *rows = robustness_rates(tmp_path).splitlines()

    assert head == "|  | rallygap | sindy |"
    assert rows[0] == "| clean sets with a physical cause named | 2 of 120 | – |"
    assert len(rows) == len(ROBUSTNESS_RATES)


def test_results_of_an_exam_without_these_groups_are_dashes(tmp_path):
    write_exam(tmp_path, {}, {})
    _, _, *rows = robustness_rates(tmp_path).splitlines()

    assert all(row.endswith("| – | – |") for row in rows)


@pytest.mark.parametrize(("cause", "gravities"), [("gravity.g", 1), ("drag.cd", 0), (None, 0)])
def test_measured_sets_have_a_row(tmp_path, cause, gravities):
    write_real(tmp_path, cause)
    sizes = " | ".join(["9 → 5 (4)"] * 3)
    row = f"| tt3d | simulator C | {sizes} | 1 of 1 | 1 of 1 | {gravities} of 1 |"
    assert real_summary(tmp_path).splitlines()[-1] == row
    assert "| 1 to 3 | 9 → 5 (4) |" in real_errors(tmp_path)


def test_leading_causes_that_all_splits_have_are_counted(tmp_path):
    write_real(tmp_path, None)
    folder, case = (
        tmp_path / "reports/real/close_gap",
        {"source": "tt3d", "simulator": "imperfect_c"},
    )
    verdicts = [
        {**case, "split": k, "verdict": one, "reduction_low_mm": low, "reduction_high_mm": high}
        for k, one, low, high in ((0, "named", 1, 2), (1, "named", -3, -2), (2, "unknown", -1, 1))
    ]
    pd.DataFrame(verdicts).to_csv(folder / "verdicts.csv", index=False)
    intervals = {"drag.cd": [(1, 3), (2, 4), (3, 5)], "magnus.cm": [(1, 2), (2, 3), (4, 5)]}
    causes = [
        {**case, "split": k, "cause": name, "role": "leading", "low": low, "high": high}
        for name, some in intervals.items()
        for k, (low, high) in enumerate(some)
    ]
    once = {**causes[0], "cause": "wind.x"}
    minor = [{**one, "cause": "wind.y", "role": "minor"} for one in causes[:3]]
    pd.DataFrame([*causes, once, *minor]).to_csv(folder / "causes.csv", index=False)

    row = "| tt3d | 2 named, 1 unknown | 1, 1 | 2 of 3 | 1 of 2 |"
    assert real_stability(tmp_path).splitlines()[-1] == row
