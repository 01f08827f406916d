"""Write the report page from the reports of all other stages."""

from rallygap.pipeline.evaluation.example_shots import read_shots
from rallygap.pipeline.io.artifacts import write_text
from rallygap.pipeline.io.report_manifest import read_contents
from rallygap.pipeline.paper.run_reports import Reports
from rallygap.pipeline.params import Params
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.transfer.example_returns import read_returns
from rallygap.pipeline.web.report_page import render_page

STAGES = [name for name in Params.model_fields if name not in ("seed", "report")]


def report(run: StageRun) -> None:
    """Write ``reports/index.html``.

    Raises:
        InputError: if a stage's report is missing or broken, naming the stage to run.
    """
    settings = run.params.report
    reports = Reports(run.root / "reports", run.params.model_dump(mode="json"))
    contents = [read_contents(reports.folder, stage) for stage in STAGES]
    shots = read_shots(run.input("evaluate_predictor", "shots.json"))[: settings.shots]
    returns = read_returns(run.input("sim2real", "returns.json"))[: settings.returns]
    write_text(reports.folder / "index.html", render_page(reports, contents, shots, returns))


if __name__ == "__main__":
    run_stage(report)
