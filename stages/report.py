"""Write the tables and figures of the pipeline that people read, and reports/index.html."""

import shutil

from rallygap.pipeline.evaluation.example_shots import read_shots
from rallygap.pipeline.report.page import write_page
from rallygap.pipeline.report.stages import PIPELINE, write_reports
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.transfer.shown_returns import read_returns

PICTURES = (  # (stage, figure): documentation pages show a copy of it in docs/images/STAGE
    ("close_gap", "causes_arena.png"),
    ("close_gap", "errors_arena.png"),
    ("evaluate_predictor", "coverage_arena.png"),
    ("evaluate_predictor", "forecast_error_arena.png"),
    ("sim2real", "transfer.png"),
    ("sim2sim", "return_rate.png"),
)


def report(run: StageRun) -> None:
    """Write the tables and figures of all stages, and one page with all of them.

    Raises:
        InputError: if a stage has not run, or a file of it is broken.
    """
    settings, items = run.params.report, write_reports(run, PIPELINE)
    shots = read_shots(run.input("evaluate_predictor", "shots.json"))[: settings.shots]
    returns = read_returns(run.input("sim2real", "returns.json"))[: settings.returns]
    write_page(run, "index.html", items, shots, returns)
    for stage, name in PICTURES:
        figure = run.root / "reports" / stage / "figures" / name
        if figure.exists():
            folder = run.root / "docs" / "images" / stage
            folder.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(figure, folder / name)


if __name__ == "__main__":
    run_stage(report)
