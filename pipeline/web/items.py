"""What the pages of verdicts and audits show: figures and tables, for the macros of items.html."""

from pathlib import Path
from typing import Any

from rallygap.pipeline.web.report_items import ReportFigure
from rallygap.pipeline.web.report_manifest import Column, read_figure


def shown_figure(figure: ReportFigure, folder: Path) -> dict[str, str]:
    """Return a figure that was written to a folder, with the picture inside.

    Raises:
        InputError: it was not.
    """
    source = read_figure(folder / f"{figure.name}.png")
    return {"title": figure.title, "caption": figure.caption, "source": source}


def page_table(columns: dict[str, list[str]]) -> dict[str, Any]:
    """Return columns as a table; a trailing blank in a name marks numbers."""
    shown = [
        Column(name.strip(), is_number=name.endswith(" "), cells=cells)
        for name, cells in columns.items()
    ]
    return {"columns": shown, "rows": range(len(shown[0].cells))}
