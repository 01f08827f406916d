"""Jinja templates of HTML pages, with the geometry that scripts of their 3-D views read.

Live views import this: it loads neither pandas nor matplotlib.
"""

from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from rallygap.models.ball import state

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


def table_geometry() -> dict[str, float]:
    """Return lengths in m of the table, the net and the ball, as the scripts read them."""
    return {
        "half_width": state.TABLE_HALF_WIDTH,
        "half_length": state.TABLE_HALF_LENGTH,
        "net_height": state.NET_HEIGHT,
        "net_overhang": state.NET_OVERHANG,
        "ball_radius": state.BALL_RADIUS,
    }
