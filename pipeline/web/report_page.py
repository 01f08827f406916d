"""The report page: figures and tables of all stages in one HTML file that works offline."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rallygap.pipeline.evaluation.example_shots import Shot
from rallygap.pipeline.io.report_manifest import (
    Contents,
    Item,
    read_columns,
    read_figure,
    read_first_frame,
)
from rallygap.pipeline.paper.run_reports import Reports
from rallygap.pipeline.transfer.example_returns import Return
from rallygap.pipeline.web.environment import page_environment
from rallygap.pipeline.web.paper_section import paper_section
from rallygap.pipeline.web.results_section import results_section
from rallygap.pipeline.web.scenes import return_scenes, shot_scenes

GAP_STAGES = ("close_gap", "hidden_effects", "retrain_policy")  # are shown first
SHOTS_STAGE, RETURNS_STAGE = "evaluate_predictor", "sim2real"  # whose runs the 3-D views show


def render_page(
    run: Reports, contents: Sequence[Contents], shots: Sequence[Shot], returns: Sequence[Return]
) -> str:
    """Render the report page; equal files give equal text.

    Args:
        run: the reports, and the parameters that they were made with.
        contents: what the stages report, in the order to show; among them those whose runs the
            3-D views show.
        shots: the shots of the first 3-D view; without any, the page has no such view.
        returns: the returns of the second.

    Raises:
        InputError: if a figure or table that the contents name is missing or broken.
    """
    stages = {one.stage: one for one in contents}
    shown = [_shown_stage(run.folder, stage) for stage in contents]
    return (
        page_environment()
        .get_template("page.html")
        .render(
            results=list(results_section(run, {one.stage: one.fingerprint for one in contents})),
            gap=[one for one in shown if one["stage"] in GAP_STAGES],
            stages=[one for one in shown if one["stage"] not in GAP_STAGES],
            paper=paper_section(run, contents),
            shot_stage=stages.get(SHOTS_STAGE),
            return_stage=stages.get(RETURNS_STAGE),
            shots=shot_scenes(shots),
            returns=return_scenes(returns),
        )
    )


def _shown_stage(reports: Path, contents: Contents) -> dict[str, Any]:
    return {
        **contents.model_dump(),
        "heading": contents.stage.replace("_", " ").capitalize(),
        "items": [_shown_item(reports / contents.stage, item) for item in contents.items],
    }


def _shown_item(folder: Path, item: Item) -> dict[str, Any]:
    path = folder / item.file
    if item.kind == "table":
        columns = read_columns(path)
        return {**item.model_dump(), "columns": columns, "rows": range(len(columns[0].cells))}
    shown = {**item.model_dump(), "source": read_figure(path)}
    return shown if item.kind == "figure" else {**shown, "still": read_first_frame(path)}
