"""Pictures that `rallygap docs` writes.

Those of the documentation are figures of stages: git keeps no other copy of these. Figures of kept
results are drawn from the tables next to them, so that a better figure needs no other results.
"""

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import pandas as pd
from matplotlib.figure import Figure

from rallygap.pipeline.documentation.cells import read_report
from rallygap.pipeline.io.artifacts import replacing
from rallygap.pipeline.report.retrain_policy import retraining_figure
from rallygap.pipeline.report.sim2real import tolerance_figure, transfer_figure
from rallygap.pipeline.report.swap_study import mechanism_figure, readings_figure
from rallygap.pipeline.web.figure_style import apply_style, save_figure

PICTURES = {  # in docs/images: the figure of a stage
    "causes_arena.png": "close_gap/figures/causes_arena.png",
    "errors_arena.png": "close_gap/figures/errors_arena.png",
    "exam_accuracy.png": "hidden_effects/figures/accuracy.png",
    "exam_confusion.png": "hidden_effects/figures/confusion.png",
    "forecast_error_arena.png": "evaluate_predictor/figures/forecast_error_arena.png",
    "coverage_arena.png": "evaluate_predictor/figures/coverage_arena.png",
    "return_rate.png": "sim2sim/figures/return_rate.png",
    "transfer.png": "sim2real/figures/transfer.png",
}


def _returns_of_arena(table: pd.DataFrame) -> Figure:
    """Draw the arena without the groups of its shots, as the stage does."""
    return retraining_figure(table[table["set"] == "arena"])


DRAWN: dict[str, tuple[str, Callable[[pd.DataFrame], Figure]]] = {  # below reports: from a table
    "swap_study/readings.png": ("swap_study/readings_all.csv", readings_figure),
    "swap_study/mechanism.png": ("swap_study/gains_mechanism.csv", mechanism_figure),
    **{
        f"{run}/{stage}/figures/{name}.png": (f"{run}/{stage}/{table}.csv", draw)
        for run in ("paper", "paper_physics", "real", "shots")
        for stage, name, table, draw in (
            ("sim2real", "transfer", "rates", transfer_figure),
            ("sim2real", "tolerance", "tolerance", tolerance_figure),
            ("retrain_policy", "returns", "returns", _returns_of_arena),
        )
    },
}


def redrawn_figures(root: Path) -> list[Path]:
    """Draw the figures of kept results from their tables; return those that have changed.

    Raises:
        InputError: a table is missing.
    """
    apply_style()
    redrawn = []
    for name, (table, draw) in DRAWN.items():
        picture = root / "reports" / name
        if _replace(picture, _content(draw(read_report(root, table)))):
            redrawn.append(picture)
    return redrawn


def _content(figure: Figure) -> bytes:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "figure.png"
        save_figure(path, figure)
        return path.read_bytes()


def renewed_pictures(root: Path) -> list[Path]:
    """Copy the figures that differ from the documentation's pictures; return these pictures.

    A stage that has not run on this machine has no figures; its pictures stay.
    """
    renewed = []
    for name, figure in PICTURES.items():
        picture, drawn = root / "docs" / "images" / name, root / "reports" / figure
        if drawn.exists() and _replace(picture, drawn.read_bytes()):
            renewed.append(picture)
    return renewed


def _replace(picture: Path, content: bytes) -> bool:
    """Write a picture that has another content; return whether it had."""
    if picture.exists() and picture.read_bytes() == content:
        return False
    with replacing(picture) as temporary:
        temporary.write_bytes(content)
    return True
