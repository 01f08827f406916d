"""The README's numbers are those of the committed run on real balls."""

import re
from pathlib import Path

import pandas as pd

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
NAMES = {
    "physics_c": "physics, simulator C",
    "physics_literature": "physics, literature",
    "oracle": "oracle",
    "transformer": "transformer",
    "transformer_fine_tuned": "transformer, fine-tuned",
}


def expected_table():
    errors = pd.read_csv(ROOT / "reports/real/evaluate_predictor/forecast_error.csv")
    errors = errors.query("against == 'measured' and quantity == 'position' and bounce == 'all'")
    lines = ["| set | predictor | 100 ms | 200 ms | 300 ms |", "|---|---|---|---|---|"]
    for (source, predictor), rows in errors.groupby(["set", "predictor"], sort=False):
        cells = [
            f"{row['mean']:.0f} ({row['ci_low']:.0f} to {row['ci_high']:.0f})"
            for _, row in rows.sort_values("horizon_ms").iterrows()
        ]
        lines.append(f"| {source} | {NAMES[predictor]} | {' | '.join(cells)} |")
    return "\n".join(lines)


def test_the_table_is_the_committed_runs():
    assert expected_table() in README


def test_every_link_into_the_repository_leads_somewhere():
    links = re.findall(r"\]\((?!https?:)([^)#]+)", README)
    assert len(links) > 10
    assert [link for link in links if not (ROOT / link).exists()] == []
