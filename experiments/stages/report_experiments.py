"""Write figures and tables of the experiments, and reports/experiments.html."""

from experiments.report import exam, forecasts, policies
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
    """Write what is drawn from the experiments' tables, and one page with all of it.

    Raises:
        InputError: if an experiment has not run, or a file of it is broken.
    """
    write_page(run, "experiments.html", write_reports(run, EXPERIMENTS), [], [])


if __name__ == "__main__":
    run_stage(report_experiments)
