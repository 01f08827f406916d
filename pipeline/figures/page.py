"""The report page: everything the stages report, in one HTML file that works offline."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from models.ball import state
from pipeline.figures.contents import (
    Contents,
    Item,
    read_columns,
    read_figure,
    read_first_frame,
)
from pipeline.figures.shots import Shot
from pipeline.figures.style import predictor_colour

SHOTS_STAGE = "evaluate_predictor"  # the stage whose run forecast the shots

TEMPLATES = Environment(
    loader=FileSystemLoader(Path(__file__).parent / "templates"),
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)


def render_page(reports: Path, contents: Sequence[Contents], shots: Sequence[Shot]) -> str:
    """Render the report page; the same files give the same text.

    Args:
        reports: the folder that holds one report folder a stage.
        contents: what the stages report, in the order to show; ``evaluate_predictor`` among them.
        shots: the shots of the 3-D view; without any, the page has no such view.

    Raises:
        InputError: if a figure or table that the contents name is missing or broken.
    """
    return TEMPLATES.get_template("page.html").render(
        stages=[_shown_stage(reports, stage) for stage in contents],
        shot_stage=next(stage for stage in contents if stage.stage == SHOTS_STAGE),
        viewer=_viewer(shots) if shots else None,
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


def _viewer(shots: Sequence[Shot]) -> dict[str, Any]:
    names = {name for shot in shots for name in shot.forecasts}
    return {
        "shots": [shot.model_dump() for shot in shots],
        "colours": {name: predictor_colour(name) for name in names},
        "table": {
            "half_width": state.TABLE_HALF_WIDTH,
            "half_length": state.TABLE_HALF_LENGTH,
            "net_height": state.NET_HEIGHT,
            "net_overhang": state.NET_OVERHANG,
            "ball_radius": state.BALL_RADIUS,
        },
    }
