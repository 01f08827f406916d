"""One run of one stage: where its files are, what it reports, and how it ends.

A stage is a function of a ``StageRun``. It reads its inputs, calls the domain packages, and adds
what they return to the report: ``run.add(item, …)`` takes the figures, animations and tables of
``rallygap.pipeline.io.report_items``, which carry their title and caption.
"""

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.io.figure_style import apply_style
from rallygap.pipeline.io.report_items import ReportItem
from rallygap.pipeline.io.report_manifest import Item
from rallygap.pipeline.params import Params, load_params
from rallygap.pipeline.runtime.console import refuse
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.provenance import Provenance, content_hash, provenance, short
from rallygap.pipeline.tracking.recording import recorded
from rallygap.pipeline.tracking.results import InputData, Results, TrainedModel


class StageRun:
    """A stage's parameters, the paths of its inputs and outputs, and its report.

    Args:
        stage: the stage's name, also its key in params.yaml and its folder under reports.
        root: the folder that holds artifacts and reports.
        params: the parameters of all stages.
        fingerprint: of the run; see ``Provenance``.

    Attributes:
        timings: name to seconds. They differ from run to run, so they go to MLflow and to
            ``timings/``, which neither DVC nor git keeps.
    """

    def __init__(self, stage: str, root: Path, params: Params, fingerprint: str = "") -> None:
        self.stage, self.root, self.params = stage, root, params
        self.fingerprint = fingerprint
        self.timings: dict[str, Any] = {}
        self.metrics: dict[str, Any] = {}
        self.items: list[Item] = []
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

    def add(self, *items: ReportItem) -> None:
        """Write figures, animations and tables into the report, in this order."""
        for item in items:
            item.write(self.report(item.item.file))
            self.items.append(item.item)

    def write_contents(self, origin: Provenance) -> None:
        """Write the report's contents.json: the run that made it and what it holds."""
        contents = {
            "stage": self.stage,
            "command": origin.command,
            "fingerprint": short(origin.fingerprint),
            "items": [item.model_dump() for item in self.items],
        }
        write_json(self.report("contents.json"), contents)

    def clear(self) -> None:
        """Remove the outputs of an earlier run of this stage, whole or broken off."""
        for folder in (self.artifact("."), self.report(".")):
            shutil.rmtree(folder, ignore_errors=True)

    def clear_scratch(self) -> None:
        """Remove what only an unfinished run needs."""
        shutil.rmtree(self.root / "scratch" / self.stage, ignore_errors=True)

    def results(self) -> Results:
        """What MLflow records at the end."""
        figures = [self.report(item.file) for item in self.items if item.kind != "table"]
        return Results(
            {**self.metrics, "timings": self.timings},
            self.inputs,
            [path for path in figures if path.exists()],
            self.models,
        )


def run_stage(stage: Callable[[StageRun], None]) -> None:
    """Run a stage from the working directory, as ``python -m stages.<name>`` does.

    A user's input error ends the process with one line and status 2.
    """
    os.environ["MPLBACKEND"] = "Agg"
    apply_style()
    try:
        params = load_params(Path("params.yaml"))
        origin = provenance(Path.cwd(), stage.__name__)
        run = StageRun(stage.__name__, Path.cwd(), params, origin.fingerprint)
        own = params.model_dump(mode="json", include={"seed", run.stage})
        with recorded(run.stage, origin, own, run.results):
            run.clear()
            try:
                stage(run)
                run.write_contents(origin)
                run.clear_scratch()
            except BaseException:
                run.clear()  # no later stage takes half of the outputs for all of them
                raise
    except InputError as error:
        refuse(error)
