"""Forecasts are scored as evaluate_predictor scores ours, to the digit."""

import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from rich.console import Console

from models.predictors.evaluation import SHOWN_HORIZONS_MS
from pipeline.benchmark.scores import score, score_tables, write_scores
from pipeline.benchmark.windows import export_windows, window_table
from pipeline.errors import InputError
from pipeline.predictors import read_contenders
from tests.pipeline.benchmark.forecasting import Still, forecasts_of
from tests.pipeline.measured_shots import params

REPOSITORY = Path(__file__).parents[3]
NUMBERS = ["mean", "std", "n", "ci_low", "ci_high"]


def predictor(root, name):
    contenders = read_contenders(root / "artifacts", params().evaluate_predictor)
    return next(one.predictor for one in contenders if one.name == name)


def scored(root, forecasts, folder):
    path = folder / "mine.parquet"
    forecasts.to_parquet(path, index=False)
    return score(root, params(), path)


@pytest.mark.parametrize("name", ["physics_c", "tiny"])
def test_our_own_predictor_exported_and_scored_has_exactly_its_numbers(tmp_path, root, sets, name):
    export_windows(sets, tmp_path)
    exported = pd.read_parquet(tmp_path / "windows.parquet")
    forecasts = forecasts_of(predictor(root, name), exported).sample(frac=1, random_state=0)
    scores = scored(root, forecasts, tmp_path)
    write_scores(tmp_path / "scores.json", scores)
    written = json.loads((tmp_path / "scores.json").read_text())
    metrics = json.loads((root / "reports/evaluate_predictor/metrics.json").read_text())
    assert set(written) == {one.name for one in sets}
    for source, quantities in written.items():
        reported = metrics[source][name]
        assert set(quantities) == set(reported)
        for quantity, horizons in quantities.items():
            for horizon, numbers in horizons.items():
                assert {key: numbers[key] for key in ("mean", "std", "n")} == (
                    reported[quantity][horizon]
                )


def test_intervals_are_those_of_the_report(tmp_path, root, sets):
    scores = scored(root, forecasts_of(predictor(root, "tiny"), window_table(sets)), tmp_path)
    report = pd.read_csv(root / "reports/evaluate_predictor/forecast_error.csv")
    ours = report.query("predictor == 'tiny' and against == 'measured' and bounce == 'all'")
    theirs = scores.errors[scores.errors["horizon_ms"].isin(SHOWN_HORIZONS_MS)]
    six_digits = theirs[NUMBERS].map(lambda value: float(f"{value:.6g}"))
    np.testing.assert_array_equal(six_digits.to_numpy(), ours[NUMBERS].to_numpy())


def test_a_set_may_be_left_out_as_a_whole(tmp_path, root, sets):
    table = window_table([one for one in sets if one.name == "plain"])
    scores = scored(root, forecasts_of(Still(), table), tmp_path)
    assert set(scores.errors["set"]) == set(scores.ours["set"]) == {"plain"}


def test_the_tables_show_theirs_above_ours_unless_the_terminal_is_narrow(tmp_path, root, sets):
    scores = scored(root, forecasts_of(Still(), window_table(sets)), tmp_path)
    shown = io.StringIO()
    console = Console(file=shown, width=140)
    for table in score_tables(scores):
        console.print(table)
    text = shown.getvalue()
    assert "…" not in text
    assert "arena: mean error of the position (mm)" in text
    first = text.split("arena: mean error of the position (mm)")[1].splitlines()[2:]
    assert [line.split()[0] for line in first[:5]] == [
        "mine.parquet", "physics_true", "physics_c", "oracle", "tiny"
    ]  # fmt: skip


def test_a_report_of_other_windows_is_not_compared_with(tmp_path, root, sets):
    (tmp_path / "artifacts").symlink_to(root / "artifacts")
    forecasts = forecasts_of(Still(), window_table(sets))
    with pytest.raises(InputError, match="dvc repro evaluate_predictor"):
        scored(tmp_path, forecasts, tmp_path)
    folder = tmp_path / "reports" / "evaluate_predictor"
    folder.mkdir(parents=True)
    report = pd.read_csv(root / "reports/evaluate_predictor/forecast_error.csv")
    report.assign(n=report["n"] + 1).to_csv(folder / "forecast_error.csv", index=False)
    with pytest.raises(InputError, match="was made on other windows"):
        scored(tmp_path, forecasts, tmp_path)


@pytest.fixture(scope="module")
def repository(tmp_path_factory, root):
    """A repository after that run, whose parameters are the repository's own."""
    made = tmp_path_factory.mktemp("repository")
    (made / "artifacts").symlink_to(root / "artifacts")
    (made / "reports").symlink_to(root / "reports")
    for name in ("params.yaml", "pyproject.toml"):
        (made / name).write_bytes((REPOSITORY / name).read_bytes())
    return made


def rallygap(*words, cwd):
    environment = {**os.environ, "PYTHONPATH": str(REPOSITORY), "COLUMNS": "80"}
    command = [sys.executable, "-c", "from pipeline.cli import main; main()"]
    return subprocess.run(
        [*command, *words], cwd=cwd, env=environment, capture_output=True, text=True
    )


def test_the_forecaster_of_the_page_works_from_export_to_score(repository):
    page = (REPOSITORY / "docs" / "benchmark.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", page, flags=re.DOTALL)
    assert len([line for line in code.splitlines() if line.strip()]) <= 20
    (repository / "my_forecaster.py").write_text(code)
    for words in re.findall(
        r"^rallygap (benchmark [^#\n]+?)\s*(?:#.*)?$", page, flags=re.MULTILINE
    ):
        finished = rallygap(*words.split(), cwd=repository)
        assert (finished.returncode, finished.stderr) == (0, "")
        if "export" in words:
            subprocess.run([sys.executable, "my_forecaster.py"], cwd=repository, check=True)
    assert "forecasts.parquet" in finished.stdout
    assert "physics_c" in finished.stdout


def test_what_is_wrong_with_a_file_is_one_line_and_status_2(repository):
    (repository / "broken.parquet").write_text("not a table")
    refused = rallygap("benchmark", "score", "broken.parquet", cwd=repository)
    assert refused.returncode == 2
    assert refused.stderr.startswith("rallygap: broken.parquet: is not a parquet table")
    assert len(refused.stderr.splitlines()) == 1
