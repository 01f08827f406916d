"""Scores of forecasts equal those of evaluate_predictor, with one window per flight."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from rallygap.models.predictors.evaluation import SHOWN_HORIZONS_MS
from rallygap.pipeline.benchmark.scores import score, write_scores
from rallygap.pipeline.benchmark.windows import export_windows, run_sets, window_table
from rallygap.pipeline.cli import app
from rallygap.pipeline.evaluation.predictors import read_predictors
from rallygap.pipeline.report.stages import PIPELINE, write_report
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.stages.evaluate_predictor import evaluate_predictor
from tests.pipeline.benchmark.forecasting import ZeroPredictor, forecasts_of
from tests.pipeline.measured_shots import params, write_inputs

REPOSITORY = Path(__file__).parents[3]
NUMBERS = ["mean", "std", "n", "ci_low", "ci_high"]


@pytest.mark.parametrize("name", ["physics_c", "tiny"])
def test_forecasts_of_our_predictor_have_exactly_its_scores(tmp_path, root, sets, name):
    export_windows(sets, tmp_path)
    exported = pd.read_parquet(tmp_path / "windows.parquet")
    ours = read_predictors(root / "artifacts", params().evaluate_predictor)
    (predictor,) = (one.predictor for one in ours if one.name == name)
    path = tmp_path / "mine.parquet"
    forecasts_of(predictor, exported).sample(frac=1, random_state=0).to_parquet(path, index=False)
    write_scores(tmp_path / "scores.json", score(root, params(), path))
    written = json.loads((tmp_path / "scores.json").read_text())
    assert set(written) == {one.name for one in sets}
    for source, predictors in written.items():
        assert predictors["mine.parquet"] == predictors[name], source
        horizons = [list(one["position"]) for one in predictors.values()]
        assert len(horizons[0]) > 3 and horizons == horizons[:1] * len(predictors)


def test_scores_equal_evaluate_predictor_where_a_flight_has_one_window(tmp_path):
    write_inputs(tmp_path)
    settings = params().evaluate_predictor.model_copy(update={"window_every_ms": 1000})
    one_window = params(evaluate_predictor=settings)
    run = StageRun("evaluate_predictor", tmp_path, one_window)
    evaluate_predictor(run)
    write_report(run, "evaluate_predictor", PIPELINE["evaluate_predictor"])
    path = tmp_path / "mine.parquet"
    table = window_table(run_sets(tmp_path, one_window))
    forecasts_of(ZeroPredictor(), table).to_parquet(path, index=False)
    scores = score(tmp_path, one_window, path)
    report = pd.read_csv(tmp_path / "reports/evaluate_predictor/forecast_error.csv")
    reported = report.query("against == 'measured' and bounce == 'all'")
    ours = scores[scores["predictor"] != "mine.parquet"]
    shown = ours[ours["horizon_ms"].isin(SHOWN_HORIZONS_MS)]
    six_digits = shown[NUMBERS].map(lambda value: float(f"{value:.6g}"))
    np.testing.assert_array_equal(six_digits.to_numpy(), reported[NUMBERS].to_numpy())


def test_a_file_named_like_one_of_our_predictors_is_an_error(tmp_path, root, sets):
    path = tmp_path / "tiny"
    forecasts_of(ZeroPredictor(), window_table(sets)).to_parquet(path, index=False)
    with pytest.raises(InputError, match="is called as a predictor of the run; give it another"):
        score(root, params(), path)


@pytest.fixture
def repository(tmp_path, root, monkeypatch):
    """The present folder: a repository with that run's artefacts and the usual parameters."""
    (tmp_path / "artifacts").symlink_to(root / "artifacts")
    for name in ("params.yaml", "pyproject.toml"):
        (tmp_path / name).write_bytes((REPOSITORY / name).read_bytes())
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    return tmp_path


def test_the_forecaster_of_the_documentation_runs(repository):
    page = (REPOSITORY / "docs" / "add-a-predictor.md").read_text(encoding="utf-8")
    page = page.partition("## Benchmark")[2]
    (code,) = re.findall(r"```python\n(.*?)```", page, flags=re.DOTALL)
    assert len([line for line in code.splitlines() if line.strip()]) <= 20
    (repository / "my_forecaster.py").write_text(code)
    for words in re.findall(r"^rallygap (benchmark [^#\n]+)", page, flags=re.MULTILINE):
        finished = CliRunner().invoke(app, words.split(), catch_exceptions=False)
        assert (finished.exit_code, finished.stderr) == (0, "")
        if "export" in words:
            subprocess.run([sys.executable, "my_forecaster.py"], check=True)
    assert "forecasts.parquet" in finished.stdout
    assert "physics_c" in finished.stdout and "…" not in finished.stdout


@pytest.mark.parametrize(
    ("out", "says"),
    [("mine.parquet", "is the file of the forecasts"), ("artifacts", "is a folder; give a file")],
)
def test_scores_that_cannot_be_written_are_refused_before_any_are_made(repository, out, says):
    forecasts = repository / "mine.parquet"
    forecasts.write_text("not read at all")
    words = ["benchmark", "score", "mine.parquet", "--out", out]
    with pytest.raises(InputError, match=says):
        CliRunner().invoke(app, words, catch_exceptions=False)
    assert forecasts.read_text() == "not read at all"
