"""Tables of the exam count what its results say."""

import json

from pipeline.documentation.gap_tables import ROBUSTNESS_RATES, robustness_rates


def written(root, first, other):
    path = root / "reports/hidden_effects/exam.json"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps({**first, "compared": {"sindy": other}}))
    return robustness_rates(root).splitlines()


def test_rates_of_robustness_groups_have_their_counts(tmp_path):
    head, _, *rows = written(
        tmp_path,
        {"clean_sets_new": 120, "false_leading": 2},
        {"clean_sets_new": 0, "false_leading": 0},
    )

    assert head == "|  | rallygap | sindy |"
    assert rows[0] == "| clean sets with a physical cause named | 2 of 120 | – |"
    assert len(rows) == len(ROBUSTNESS_RATES)


def test_results_of_an_exam_without_these_groups_are_dashes(tmp_path):
    _, _, *rows = written(tmp_path, {}, {})

    assert all(row.endswith("| – | – |") for row in rows)
