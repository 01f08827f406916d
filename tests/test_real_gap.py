"""The page on real balls has the numbers of the committed run."""

from pathlib import Path

import pandas as pd
import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/real_gap.md").read_text(encoding="utf-8")
RESULTS = ROOT / "reports/real/close_gap"
BEGUN = {
    "imperfect_c": "C",
    "without_magnus": "C without lift",
    "from_literature": "literature",
}
SETS = ("spindoe", "tt3d", "isr_ball_prediction")
HORIZONS_MS = (100, 200, 300)
OFTEN = 2  # splits of three


def read(name):
    table = pd.read_csv(RESULTS / f"{name}.csv")
    return table[table["source"].isin(SETS)]


def expected_summary():
    """What naming was worth, a row for each set and beginning, its splits together."""
    errors, verdicts, causes = read("errors"), read("verdicts"), read("stability")
    lines = [
        "| set | from | 100 ms | 200 ms | 300 ms | surely less | gravity named |",
        "|---|---|---|---|---|---|---|",
    ]
    for (source, begun), rows in verdicts.groupby(["source", "simulator"], sort=False):
        chosen = "source == @source and simulator == @begun"
        mean = errors.query(chosen).groupby("horizon_ms").mean(numeric_only=True)
        cells = [told(mean.loc[horizon]) for horizon in HORIZONS_MS]
        less = f"{(rows['closer_low_mm'] > 0).sum()} of {len(rows)}"
        gravity = causes.query(f"{chosen} and cause == 'gravity'")["found"].sum()
        cells += [less, f"{gravity} of {len(rows)}"]
        lines.append(f"| {source} | {BEGUN[begun]} | {' | '.join(cells)} |")
    return "\n".join(lines)


def told(row):
    return f"{row['before_mm']:.0f} → {row['after_mm']:.0f} ({row['floor_mm']:.0f})"


def expected_errors():
    """Errors on shots that naming never saw, a row a case."""
    errors = read("errors").set_index(["source", "simulator", "split", "horizon_ms"])
    lines = [
        "| set | from | split | verdict | 100 ms | 200 ms | 300 ms | fell by | landing |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for row in read("verdicts").itertuples():
        case = (row.source, row.simulator, row.split)
        cells = [said(errors, case, horizon) for horizon in HORIZONS_MS]
        cells.append(f"{row.closer_low_mm:.0f} to {row.closer_high_mm:.0f}")
        ends = (row.landing_before_mm, row.landing_after_mm, row.landing_floor_mm)
        cells.append("{:.0f} → {:.0f} ({:.0f})".format(*ends) if pd.notna(ends[0]) else "–")
        name = f"{row.source} | {BEGUN[row.simulator]} | {row.split} | {row.verdict}"
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def said(errors, case, horizon):
    if (*case, horizon) not in errors.index:
        return "–"
    return told(errors.loc[(*case, horizon)])


def expected_causes():
    """Causes that two splits of three agree on."""
    lines = ["| set | from | cause | splits | estimates |", "|---|---|---|---|---|"]
    for row in read("stability").query("found >= @OFTEN").itertuples():
        unit = "" if row.unit == "1" else f" {row.unit}"
        ends = f"{row.lowest:.3g} to {row.highest:.3g}{unit}"
        name = f"{row.source} | {BEGUN[row.simulator]} | {row.cause}"
        lines.append(f"| {name} | {row.found:.0f} of {row.splits} | {ends} |")
    return "\n".join(lines)


@pytest.mark.parametrize("expected", [expected_summary, expected_errors, expected_causes])
def test_the_tables_are_the_committed_run_s(expected):
    assert expected() in PAGE


@pytest.mark.parametrize("source", SETS)
@pytest.mark.parametrize("figure", ["causes", "errors"])
def test_the_pictures_are_kept(source, figure):
    name = f"reports/real/close_gap/figures/{figure}_{source}.png"
    assert (ROOT / name).exists()
    assert f"../{name}" in PAGE
