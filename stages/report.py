"""Write the report page from what the stages before it report."""

from pipeline.artifacts import write_text
from pipeline.figures.contents import read_contents
from pipeline.figures.page import render_page
from pipeline.figures.shots import read_shots
from pipeline.run import StageRun, run_stage

STAGES = (
    "ingest",
    "segment",
    "score_segmentation",
    "train_predictor",
    "close_gap",
    "evaluate_predictor",
    "train_policy",
    "sim2sim",
    "sim2real",
    "retrain_policy",
    "hidden_effects",
)


def report(run: StageRun) -> None:
    """Write ``reports/index.html``.

    Raises:
        InputError: if a stage's report is missing or broken, naming the stage to run.
    """
    reports = run.root / "reports"
    contents = [read_contents(reports, stage) for stage in STAGES]
    shots = read_shots(run.input("evaluate_predictor", "shots.json"))
    page = render_page(reports, contents, shots[: run.params.report.shots])
    write_text(reports / "index.html", page)


if __name__ == "__main__":
    run_stage(report)
