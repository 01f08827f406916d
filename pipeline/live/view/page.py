"""The page of the view, which works offline but for the events of its server."""

from pathlib import Path

from rallygap.pipeline.web.environment import page_environment
from rallygap.pipeline.web.table_geometry import table_geometry

TEMPLATES = Path(__file__).parent / "templates"


def render_view() -> str:
    """Render the page."""
    template = page_environment(TEMPLATES).get_template("live.html")
    return template.render(view={"table": table_geometry()})
