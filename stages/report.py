"""Write the tables and figures of the pipeline that people read, and reports/index.html."""

import shutil

from rallygap.pipeline.evaluation.example_shots import read_shots
from rallygap.pipeline.report.page import write_page
from rallygap.pipeline.report.stages import PIPELINE, write_reports
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.transfer.example_returns import read_returns

PICTURES = {  # of documentation pages, in docs/images: the figure that each is a copy of
    "causes_arena.png": "close_gap/figures/causes_arena.png",
    "errors_arena.png": "close_gap/figures/errors_arena.png",
    "forecast_error_arena.png": "evaluate_predictor/figures/forecast_error_arena.png",
    "coverage_arena.png": "evaluate_predictor/figures/coverage_arena.png",
    "return_rate.png": "sim2sim/figures/return_rate.png",
    "transfer.png": "sim2real/figures/transfer.png",
}


def report(run: StageRun) -> None:
    """Write the tables and figures of all stages, and one page with all of them.

    Raises:
        InputError: if a stage has not run, or a file of it is broken.
    """
    settings, items = run.params.report, write_reports(run, PIPELINE)
    shots = read_shots(run.input("evaluate_predictor", "shots.json"))[: settings.shots]
    returns = read_returns(run.input("sim2real", "returns.json"))[: settings.returns]
    write_page(run, "index.html", items, shots, returns)
    for name, figure in PICTURES.items():
        if (run.root / "reports" / figure).exists():
            shutil.copyfile(run.root / "reports" / figure, run.root / "docs" / "images" / name)


if __name__ == "__main__":
    run_stage(report)
