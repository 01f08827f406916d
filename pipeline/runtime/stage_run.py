"""One run of one stage: where its files are, what it keeps, and how it ends.

A stage is a function of a ``StageRun``. It reads its inputs, calls the domain packages, and keeps
tables: ``run.keep(errors=…)``. The stage ``report`` makes the tables and figures that people read
from them (``pipeline.report``), so that a caption or a colour is no dependency of a computation.
"""

import os
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from rallygap.pipeline.io.artifacts import read_table, write_csv, write_json, write_table
from rallygap.pipeline.params import Params, load_params
from rallygap.pipeline.runtime.console import refuse
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.provenance import content_hash, provenance, short
from rallygap.pipeline.tracking.results import InputData, Results, TrainedModel
from rallygap.pipeline.tracking.runs import tracked_stage

KEPT = "report"  # folder among a stage's artefacts


class StageRun:
    """A stage's parameters, the paths of its inputs and outputs, and its metrics.

    Args:
        stage: the stage's name, also its key in params.yaml and its folder under reports.
        root: the folder that holds artifacts and reports.
        params: the parameters of all stages.
        fingerprint: of the run; see ``Provenance``.

    Attributes:
        timings: name to seconds. They differ from run to run, so they go to MLflow and to
            ``timings/``, which neither DVC nor git keeps.
        figures: paths of the figures that MLflow records.
        tables: paths of the tables that are published.
    """

    def __init__(self, stage: str, root: Path, params: Params, fingerprint: str = "") -> None:
        self.stage, self.root, self.params = stage, root, params
        self.fingerprint = fingerprint
        self.timings: dict[str, Any] = {}
        self.metrics: dict[str, Any] = {}
        self.figures: list[Path] = []
        self.tables: list[Path] = []
        self.inputs: list[InputData] = []
        self.models: list[TrainedModel] = []

    @property
    def seed(self) -> int:
        """The seed of every random draw of this stage."""
        return self.params.seed

    def input(self, stage: str, name: str) -> Path:
        """The path of an artefact of another stage."""
        return self.root / "artifacts" / stage / name

    def artifact(self, name: str) -> Path:
        """The path of an artefact of this stage."""
        return self.root / "artifacts" / self.stage / name

    def scratch(self, name: str) -> Path:
        """The path of a folder for checkpoints, found again by a run with the same fingerprint."""
        return self.root / "scratch" / self.stage / short(self.fingerprint) / name

    def report(self, name: str) -> Path:
        """The path of a file of this stage's report."""
        return self.root / "reports" / self.stage / name

    def log_input(self, name: str, path: Path, rows: int) -> None:
        """Note a data set that this stage reads, for MLflow."""
        self.inputs.append(InputData(name, str(path), rows, content_hash(path)))

    def write_metrics(self, metrics: dict[str, Any]) -> None:
        """Write nested metrics as the report's metrics.json."""
        self.metrics = metrics
        write_json(self.report("metrics.json"), metrics)

    def keep(self, **tables: pd.DataFrame) -> None:
        """Write tables for the stage ``report``."""
        for name, table in tables.items():
            write_table(self.artifact(f"{KEPT}/{name}.parquet"), table)

    def publish(self, tables: Mapping[str, pd.DataFrame], digits: int = 4) -> None:
        """Write tables as CSV files of the report, so many significant digits a number.

        For stages whose results are in git, because they take hours; ``report`` publishes others.
        """
        for name, table in tables.items():
            self.tables.append(self.report(f"{name}.csv"))
            write_csv(self.tables[-1], table, digits)

    def published(self, stage: str, name: str) -> pd.DataFrame:
        """Return a table that a stage has published.

        Raises:
            InputError: there is no such table.
        """
        path = self.root / "reports" / stage / f"{name}.csv"
        if not path.is_file():
            raise InputError(path, f"is missing; run `python -m experiments.stages.{stage}`")
        return pd.read_csv(path)

    def kept(self, stage: str, name: str) -> pd.DataFrame:
        """Return a table that a stage has kept."""
        return read_table(self.input(stage, f"{KEPT}/{name}.parquet"))

    def clear(self) -> None:
        """Remove the outputs of an earlier run of this stage, whole or broken off."""
        shutil.rmtree(self.artifact("."), ignore_errors=True)
        for path in (self.report("metrics.json"), *self.tables):
            path.unlink(missing_ok=True)

    def clear_scratch(self) -> None:
        """Remove what only an unfinished run needs."""
        shutil.rmtree(self.root / "scratch" / self.stage, ignore_errors=True)

    def results(self) -> Results:
        """What MLflow records at the end."""
        metrics = {**self.metrics, "timings": self.timings}
        return Results(metrics, self.inputs, self.figures, self.models)


def run_stage(stage: Callable[[StageRun], None]) -> None:
    """Run a stage from the working directory, as ``python -m rallygap.stages.<name>`` does.

    A user's input error ends the process with one line and status 2.
    """
    try:
        params = load_params(Path("params.yaml"))
        if params.cores:
            os.environ["LOKY_MAX_CPU_COUNT"] = str(params.cores)  # joblib's
        origin = provenance(Path.cwd(), stage.__name__)
        run = StageRun(stage.__name__, Path.cwd(), params, origin.fingerprint)
        own = params.model_dump(mode="json", include={"seed", run.stage})
        with tracked_stage(run.stage, origin, own, run.results):
            run.clear()
            try:
                stage(run)
                run.clear_scratch()
            except BaseException:
                run.clear()  # no later stage takes half of the outputs for all of them
                raise
    except InputError as error:
        refuse(error)
