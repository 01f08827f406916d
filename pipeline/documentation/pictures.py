"""Pictures of the documentation, which are figures of stages: git keeps no other copy of these."""

from pathlib import Path

from pipeline.io.artifacts import replacing

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


def renewed_pictures(root: Path) -> list[Path]:
    """Copy the figures that differ from the documentation's pictures; return these pictures.

    A stage that has not run on this machine has no figures; its pictures stay.
    """
    renewed = []
    for name, figure in PICTURES.items():
        picture, drawn = root / "docs" / "images" / name, root / "reports" / figure
        if drawn.exists() and not _equal(picture, drawn):
            with replacing(picture) as temporary:
                temporary.write_bytes(drawn.read_bytes())
            renewed.append(picture)
    return renewed


def _equal(picture: Path, drawn: Path) -> bool:
    return picture.exists() and picture.read_bytes() == drawn.read_bytes()
