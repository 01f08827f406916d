"""A stage runs whole or not at all, and the same inputs give the same bytes."""

import json
import multiprocessing
import os
import shutil
import signal
from contextlib import nullcontext
from pathlib import Path

import pandas as pd
import pytest
from joblib import cpu_count

from rallygap.pipeline.io.artifacts import replacing, write_table
from rallygap.pipeline.runtime import stage_run as run_module
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.provenance import provenance
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.tracking import runs as tracking

ROOT = Path(__file__).parents[3]

DVC_YAML = """
stages:
  segment:
    cmd: python -m rallygap.stages.segment
    deps: [code]
    params: [seed, segment]
    outs: [artifacts/segment]
"""


@pytest.fixture
def repository(tmp_path, monkeypatch):
    """A repository with one stage, `segment`, as the working directory, without tracking."""
    shutil.copy(ROOT / "params.yaml", tmp_path)
    (tmp_path / "dvc.yaml").write_text(DVC_YAML)
    (tmp_path / "code").mkdir()
    (tmp_path / "code" / "a.py").write_text("1")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(run_module, "tracked_stage", lambda *_: nullcontext())
    return tmp_path


def segment(run: StageRun) -> None:
    """A stage that writes one of everything."""
    table = pd.DataFrame({"name": ["a", "b"], "value": [1 / 3, 2.0]})
    write_table(run.artifact("episodes.parquet"), table)
    run.keep(values=table)
    run.publish({"values": table})
    run.write_metrics({"a": {"mean": 1 / 3}})


def files(folder):
    return {
        path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()
    }


def exit_status(stage):
    with pytest.raises(SystemExit) as caught:
        run_stage(stage)
    return caught.value.code


def test_a_run_leaves_artefacts_tables_and_metrics_with_the_same_bytes_each_time(repository):
    run_stage(segment)
    for name in ("episodes", "report/values"):
        kept = pd.read_parquet(f"artifacts/segment/{name}.parquet")
        assert kept["value"].tolist() == [1 / 3, 2.0]
    assert Path("reports/segment/values.csv").read_text() == "name,value\na,0.3333\nb,2\n"
    assert json.loads(Path("reports/segment/metrics.json").read_text()) == {"a": {"mean": 1 / 3}}
    first = files(repository)
    run_stage(segment)
    assert files(repository) == first


def test_a_stage_uses_no_more_cores_than_it_may(repository, monkeypatch):
    monkeypatch.setenv("LOKY_MAX_CPU_COUNT", "2")
    params = Path("params.yaml").read_text()
    Path("params.yaml").write_text(params.replace("cores: null", "cores: 1"))
    run_stage(segment)
    assert cpu_count() == 1


@pytest.mark.parametrize(
    ("file", "text"),
    [("code/a.py", "2"), ("code/b.py", ""), ("params.yaml", None), ("dvc.yaml", None)],
)
def test_the_fingerprint_follows_code_parameters_and_command(repository, file, text):
    first = provenance(repository, "segment").fingerprint
    path = repository / file
    changes = path.read_text() if text is None else text
    path.write_text(changes.replace("seed: 1", "seed: 2").replace("python -m", "python3 -m"))
    assert provenance(repository, "segment").fingerprint != first


def test_an_input_error_is_one_line_and_leaves_nothing(repository, capsys):
    def segment_badly(run):
        segment(run)
        raise InputError("balls.csv", "is empty", row=3)

    segment_badly.__name__ = "segment"
    run_stage(segment)
    assert exit_status(segment_badly) == 2
    assert capsys.readouterr().err == "rallygap: balls.csv, row 3: is empty\n"
    assert files(repository / "artifacts") == files(repository / "reports") == {}
    shutil.rmtree(repository / "code")
    assert exit_status(segment) == 2
    problem = "is missing; `dvc repro` runs the stage that writes it"
    assert capsys.readouterr().err == f"rallygap: {repository / 'code'}: {problem}\n"
    params = Path("params.yaml").read_text()
    Path("params.yaml").write_text(params.replace("seed: 1", "seed: -1\nsed: 0"))
    assert exit_status(segment) == 2
    assert capsys.readouterr().err.count("rallygap: params.yaml, se") == 2


def test_a_killed_stage_leaves_no_half_file_and_runs_again(repository):
    def segment_killed(run):
        with replacing(run.artifact("episodes.parquet")) as temporary:
            temporary.write_bytes(b"half")
            os.kill(os.getpid(), signal.SIGKILL)

    segment_killed.__name__ = "segment"
    stage = multiprocessing.get_context("fork").Process(target=run_stage, args=(segment_killed,))
    stage.start()
    stage.join()
    assert stage.exitcode == -signal.SIGKILL
    assert not Path("artifacts/segment/episodes.parquet").exists()
    run_stage(segment)
    left = {str(path) for path in files(repository / "artifacts")}
    assert left == {"segment/episodes.parquet", "segment/report/values.parquet"}


def segment_at_length(run: StageRun) -> None:
    """A stage that counts its runs in a scratch folder, and fails the first two times."""
    counted = run.scratch("counting")
    runs = len(list(counted.glob("*"))) + 1
    (counted / str(runs)).mkdir(parents=True)
    write_table(run.artifact("episodes.parquet"), pd.DataFrame({"a": [1]}))
    run.timings["counting"] = {"runs": runs}
    if runs < 3:
        raise RuntimeError("too early")


segment_at_length.__name__ = "segment"


def test_a_failed_run_leaves_its_scratch_to_the_next_and_timings_are_in_no_output(
    repository, monkeypatch
):
    monkeypatch.setattr(run_module, "tracked_stage", tracking.tracked_stage)
    monkeypatch.setattr(tracking, "attempt", lambda *_: None)
    for _ in range(2):
        with pytest.raises(RuntimeError, match="early"):
            run_stage(segment_at_length)
    assert files(repository / "artifacts") == files(repository / "reports") == {}
    assert not Path("timings").exists()
    run_stage(segment_at_length)
    assert not list((repository / "scratch" / "segment").glob("*"))
    (kept,) = Path("timings/segment").glob("*.json")
    assert json.loads(kept.read_text()) == {"counting": {"runs": 3}}
    outputs = {**files(repository / "artifacts"), **files(repository / "reports")}
    assert outputs and not any(b"runs" in content for content in outputs.values())
