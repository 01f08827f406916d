"""The report as a PDF: figures and tables of a run; equal reports give equal bytes."""

from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from itertools import accumulate
from pathlib import Path
from textwrap import wrap

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from pipeline.io.figure_style import INK, MUTED
from pipeline.io.report_manifest import Contents, Item, read_columns, read_picture
from pipeline.paper.comparison import CONTEXT, exhibits, groups
from pipeline.paper.run_reports import Reports

A4 = (8.27, 11.69)  # inch
LEFT, TOP, BOTTOM = 0.08, 0.94, 0.06  # margins as shares of the page
BODY, SMALLEST = 7.5, 3.8  # points
LETTER = 0.602  # width of a letter of DejaVu Sans Mono, in font sizes
LEADING = 1.35  # height of a line, in font sizes
WIDEST = 46  # letters in a cell before it is wrapped
FIXED_DATE = datetime(2000, 1, 1, tzinfo=UTC)  # a date that no run changes
METADATA = {
    "Title": "rallygap report",
    "Creator": None,
    "Producer": None,
    "CreationDate": FIXED_DATE,
}

Row = Sequence[str]


def write_pdf(path: Path, run: Reports, contents: Sequence[Contents]) -> None:
    """Write the figures and tables of a run, and the comparison with the paper.

    Args:
        path: of the PDF.
        run: the reports, and the parameters that they were made with.
        contents: what the stages report, in the order to show.

    Raises:
        InputError: if a figure or table that the contents name is missing or broken.
    """
    with PdfPages(path, metadata=METADATA) as pages:
        for number, figure in enumerate(_figures(run, contents), start=1):
            figure.text(1 - LEFT, BOTTOM / 2, str(number), ha="right", color=MUTED, fontsize=7)
            pages.savefig(figure)


def _figures(run: Reports, contents: Sequence[Contents]) -> Iterator[Figure]:
    yield from _paper(run, contents)
    for stage in contents:
        for item in stage.items:
            made = f"Stage {stage.stage}, run {stage.fingerprint}, file {stage.stage}/{item.file}."
            path = run.folder / stage.stage / item.file
            yield from (
                _table(item, path, made) if item.kind == "table" else _picture(item, path, made)
            )


def _paper(run: Reports, contents: Sequence[Contents]) -> Iterator[Figure]:
    """Yield the pages of the comparison with the paper."""
    runs = ", ".join(f"{stage.stage} {stage.fingerprint}" for stage in contents)
    about = (
        "Bridging the sim2real gap in the table tennis robot with a transformer-based ball states "
        f"predictor (Bi et al., Sony AI) compared with this run. {CONTEXT} Stages and their runs: "
        f"{runs}."
    )
    rows: list[Row] = [(one.name, one.what, one.stage, one.verdict(run)) for one in exhibits()]
    yield from _listed(
        "Comparison with the paper", about, ("in the paper", "what", "stage", "verdict"), rows
    )
    for group in groups():
        rows = [
            (value.what, value.printed_text, found.shown, value.stage, found.verdict)
            for value, found in group.findings(run)
        ]
        names = ("what", "the paper", "ours", "stage", "verdict")
        yield from _listed(group.title, group.about, names, rows)


def _picture(item: Item, path: Path, made: str) -> Iterator[Figure]:
    """Yield the page of a figure, or of the first frame of an animation."""
    pixels = read_picture(path).convert("RGB")
    figure, top = _page(item.title, f"{item.caption} {made}")
    width = 1 - 2 * LEFT
    height = min(width * A4[0] / A4[1] * pixels.height / pixels.width, top - BOTTOM)
    axes = figure.add_axes((LEFT, top - height, width, height))
    axes.imshow(pixels, interpolation="none")
    axes.axis("off")
    yield figure


def _table(item: Item, path: Path, made: str) -> Iterator[Figure]:
    columns = read_columns(path)
    rows = list(zip(*(column.cells for column in columns), strict=True))
    names = [column.name for column in columns]
    yield from _listed(item.title, f"{item.caption} {made}", names, rows)


def _listed(title: str, about: str, names: Row, rows: Sequence[Row]) -> Iterator[Figure]:
    """Yield the pages of a table, each with its header."""
    wrapped = [[wrap(cell, WIDEST) or [""] for cell in row] for row in [names, *rows]]
    widths = [
        max(len(line) for row in wrapped for line in row[column]) for column in range(len(names))
    ]
    room = 72 * A4[0] * (1 - 2 * LEFT)
    size = min(BODY, max(SMALLEST, room / LETTER / (sum(widths) + 2 * len(widths))))
    head, *blocks = ["\n".join(_lines(row, widths)) for row in wrapped]
    while blocks:
        figure, top = _page(title, about)
        left = int(72 * A4[1] * (top - BOTTOM) / (LEADING * size)) - head.count("\n") - 2
        ends = accumulate(block.count("\n") + 1 for block in blocks)
        fit = max(1, sum(end <= left for end in ends))
        text = "\n".join([head, "", *blocks[:fit]])
        figure.text(
            LEFT, top, text, va="top", color=INK, family="DejaVu Sans Mono", fontsize=size,
            linespacing=LEADING, parse_math=False,
        )  # fmt: skip
        yield figure
        blocks, about = blocks[fit:], ""


def _lines(row: Sequence[Sequence[str]], widths: Sequence[int]) -> Iterator[str]:
    """Yield the lines of a row whose cells have several."""
    for line in range(max(map(len, row))):
        cells = [cell[line] if line < len(cell) else "" for cell in row]
        padded = (cell.ljust(width) for cell, width in zip(cells, widths, strict=True))
        yield "  ".join(padded).rstrip()


def _page(title: str, about: str) -> tuple[Figure, float]:
    """Return a page with its heading, and the top of its content as a share of its height."""
    figure = Figure(figsize=A4)
    figure.set_layout_engine("none")
    text = "\n".join(wrap(about, 115))
    lines = text.count("\n") + 1 if text else 0
    figure.text(LEFT, TOP, title, fontsize=12, weight="bold", color=INK, parse_math=False)
    figure.text(
        LEFT, TOP - 0.012, text, va="top", fontsize=BODY, color=MUTED, linespacing=LEADING,
        parse_math=False,
    )  # fmt: skip
    return figure, TOP - 0.025 - lines * BODY * LEADING / 72 / A4[1]
