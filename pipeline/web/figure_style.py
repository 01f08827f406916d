"""How every figure looks: one matplotlib style, one fixed colour a predictor and a contact."""

import io
import zlib
from pathlib import Path

import matplotlib.style
from matplotlib.figure import Figure
from PIL import Image

from rallygap.pipeline.io.artifacts import replacing

FIGURE_DPI = 300
COLOURS = 256  # of a picture, which makes its file a third as large
FIGURE_WIDTH = 8.0  # inch; every figure is this wide, so that text has one size on the page
INK = "#20262d"
MUTED = "#66707a"

STYLE = {
    "figure.dpi": 160,
    "figure.constrained_layout.use": True,
    "font.family": "DejaVu Sans",  # shipped with matplotlib: the same on every machine
    "font.size": 9,
    "text.color": INK,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "axes.titlepad": 8,
    "axes.labelcolor": INK,
    "axes.edgecolor": MUTED,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e3e7ea",
    "grid.linewidth": 0.7,
    "lines.linewidth": 1.8,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.major.size": 3,
    "ytick.major.size": 3,
}

# Hues that people with any common colour blindness tell apart (Okabe and Ito 2008, Tol 2021), at
# least 3:1 against the page's light and dark backgrounds.
CONTACT_COLOURS = {
    "racket": "#d55e00",
    "table": "#009988",
    "floor": "#8a6fd1",
    "net": "#b8860b",
    "unknown": "#7d8791",
}
# In the order of legends: physics, what bounds all others, trained predictors.
_PREDICTOR_COLOURS = {
    "physics_c": "#0f7fc4",
    "physics_literature": "#d55e00",
    "oracle": "#7d8791",
    "hybrid": "#c94f6d",
    "transformer": "#009988",
    "transformer_fine_tuned": "#8a6fd1",
    "tae": "#b85fa0",
    "gru_tae": "#a08000",
}
_OTHER_COLOURS = ["#5b7f2b", "#3f6f9c", "#9c6b3f"]


def apply_style() -> None:
    """Make matplotlib draw every figure of this process in the project's style.

    Ticks take their style when they are first drawn, so a style for the time of one plotting
    function would not reach them.
    """
    matplotlib.style.use(STYLE)


def save_figure(path: Path, figure: Figure) -> None:
    """Write a figure as a picture; same figure, same bytes."""
    drawn = io.BytesIO()
    figure.savefig(drawn, dpi=FIGURE_DPI)
    picture = Image.open(drawn).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    with replacing(path) as temporary:
        picture.save(temporary, "PNG", optimize=True, dpi=(FIGURE_DPI, FIGURE_DPI))


def predictor_colour(name: str) -> str:
    """Return the colour ``#rrggbb`` of a predictor, the same in every figure it appears in."""
    other = _OTHER_COLOURS[zlib.crc32(name.encode()) % len(_OTHER_COLOURS)]
    return _PREDICTOR_COLOURS.get(name, other)


def predictor_order(name: str) -> tuple[int, str]:
    """Return what sorts predictors as legends list them: known ones first, others by name."""
    known = list(_PREDICTOR_COLOURS)
    return (known.index(name) if name in known else len(known)), name
