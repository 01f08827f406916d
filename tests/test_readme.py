"""The README's numbers are those of the committed runs."""

import re
from pathlib import Path

import pandas as pd
import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
NAMES = {
    "physics_c": "physics, simulator C",
    "physics_literature": "physics, literature",
    "oracle": "oracle",
    "transformer": "transformer",
    "transformer_fine_tuned": "transformer, fine-tuned",
}


def expected_table(report, of_arena):
    """Position errors of a run, on the arena or on the measured sets."""
    errors = pd.read_csv(ROOT / report / "evaluate_predictor/forecast_error.csv")
    errors = errors.query("against == 'measured' and quantity == 'position' and bounce == 'all'")
    errors = errors[(errors["set"] == "arena") == of_arena]
    lines = ["| set | predictor | 100 ms | 200 ms | 300 ms |", "|---|---|---|---|---|"]
    for (source, predictor), rows in errors.groupby(["set", "predictor"], sort=False):
        cells = [
            f"{row['mean']:.0f} ({row['ci_low']:.0f} to {row['ci_high']:.0f})"
            for _, row in rows.sort_values("horizon_ms").iterrows()
        ]
        lines.append(f"| {source} | {NAMES[predictor]} | {' | '.join(cells)} |")
    return "\n".join(lines)


@pytest.mark.parametrize(("report", "of_arena"), [("reports", True), ("reports/real", False)])
def test_the_tables_are_the_committed_runs(report, of_arena):
    assert expected_table(report, of_arena) in README


def test_every_link_into_the_repository_leads_somewhere():
    links = re.findall(r"\]\((?!https?:)([^)#]+)", README)
    assert len(links) > 10
    assert [link for link in links if not (ROOT / link).exists()] == []
