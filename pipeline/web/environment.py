"""Jinja templates of HTML pages: one environment with the shared base page, styles and table."""

from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

SHARED = Path(__file__).parent / "templates"


def page_environment(*folders: Path) -> Environment:
    """Return the templates of these folders, and the shared ones that they extend or include."""
    return Environment(
        loader=FileSystemLoader([*folders, SHARED]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
