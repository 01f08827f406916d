"""The report page: figures and tables of all stages in one HTML file that works offline."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rallygap.pipeline.evaluation.example_shots import Shot
from rallygap.pipeline.io.artifacts import write_text
from rallygap.pipeline.paper.run_reports import Reports
from rallygap.pipeline.report.paper import paper_section
from rallygap.pipeline.report.results import results_section
from rallygap.pipeline.report.scenes import return_scenes, shot_scenes
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.transfer.shown_returns import Return
from rallygap.pipeline.web.environment import page_environment
from rallygap.pipeline.web.pages import read_columns, read_figure, read_first_frame
from rallygap.pipeline.web.report_items import Written

GAP_STAGES = ("close_gap", "exam", "retrain_policy")  # are shown first


def write_page(
    run: StageRun,
    name: str,
    items: Mapping[str, Sequence[Written]],
    shots: Sequence[Shot],
    returns: Sequence[Return],
) -> None:
    """Write a report page below ``reports``, and note its figures for MLflow."""
    reports = run.root / "reports"
    params = run.params.model_dump(mode="json")
    write_text(reports / name, render_page(Reports(reports, params), items, shots, returns))
    run.figures += [
        reports / stage / item.file
        for stage, members in items.items()
        for item in members
        if item.kind != "table"
    ]


def render_page(
    run: Reports,
    items: Mapping[str, Sequence[Written]],
    shots: Sequence[Shot],
    returns: Sequence[Return],
) -> str:
    """Render the report page; equal files give equal text.

    Args:
        run: the reports, and the parameters that they were made with.
        items: what each stage reports, written to its folder, in the order to show.
        shots: the shots of the first 3-D view; without any, the page has no such view.
        returns: the returns of the second.

    Raises:
        InputError: if a figure or table is missing or broken.
    """
    shown = [
        {
            "stage": stage,
            "heading": stage.replace("_", " ").capitalize(),
            "items": [_shown(run.folder / stage, item) for item in members],
        }
        for stage, members in items.items()
    ]
    anchors = {f"{stage}/{item.file}" for stage, members in items.items() for item in members}
    template = page_environment().get_template("page.html")
    return template.render(
        results=list(results_section(run, anchors)),
        gap=[section for section in shown if section["stage"] in GAP_STAGES],
        stages=[section for section in shown if section["stage"] not in GAP_STAGES],
        paper=paper_section(run, {*anchors, *items}) if "sim2real" in items else None,
        shots=shot_scenes(shots),
        returns=return_scenes(returns),
    )


def _shown(folder: Path, item: Written) -> dict[str, Any]:
    path = folder / item.file
    if item.kind == "table":
        columns = read_columns(path)
        return item._asdict() | {"columns": columns, "rows": range(len(columns[0].cells))}
    still = read_first_frame(path) if item.kind == "animation" else ""
    return item._asdict() | {"source": read_figure(path), "still": still}
