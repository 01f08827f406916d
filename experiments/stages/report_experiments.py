"""Write figures and tables of the experiments, reports/experiments.html and docs/paper.md."""

from experiments.report import exam, forecasts, policies
from experiments.report.paper_page import paper_page
from rallygap.pipeline.io.artifacts import write_text
from rallygap.pipeline.report.page import write_page
from rallygap.pipeline.report.stages import Reports, write_reports
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage

EXPERIMENTS: Reports = {
    "exam": exam.items,
    "arenas": forecasts.arenas,
    "learning_curves": forecasts.learning_curves,
    "real_forecasts": forecasts.real_forecasts,
    "swap_study": policies.swap_study,
    "spread_policies": policies.spread_policies,
    "paper_network": forecasts.paper_network,
}


def report_experiments(run: StageRun) -> None:
    """Write what follows from the experiments' tables, and the comparison of runs with the paper.

    Raises:
        InputError: if an experiment has not run, or a file of it is broken.
    """
    write_page(run, "experiments.html", write_reports(run, EXPERIMENTS), [], [])
    write_text(run.root / "docs" / "paper.md", paper_page(run.root))


if __name__ == "__main__":
    run_stage(report_experiments)
