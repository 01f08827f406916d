"""A simulator as code: the file ``ball_effects.py``, with what an engine needs to call it."""

from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import (
    BALL_MASS,
    BALL_RADIUS,
    DRAG_FACTOR,
    MAGNUS_FACTOR,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
)
from rallygap.pipeline.engines.export.hooks import (
    constants,
    context_code,
    hook_code,
    quantity_functions,
)

CODE = "ball_effects.py"  # name of the file
ENGINES = ("python", "pybullet", "mujoco")  # that have a template
TEMPLATES = Path(__file__).parent / "templates"
PLAIN = ("DRAG_FACTOR", "MAGNUS_FACTOR")  # constants that every file has


def ball_effects(simulator: Simulator, title: str, provenance: Sequence[str], engine: str) -> str:
    """Return the file for an engine.

    Args:
        simulator: whose flight and bounce it has; surfaces but the table, and the sensor, are left
            out.
        title: what it is, in a few words.
        provenance: lines on where its values come from.
        engine: one of ``ENGINES``.
    """
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    named = constants(simulator).items()
    return environment.get_template("ball_effects.py.jinja").render(
        title=title,
        version=version("rallygap"),
        provenance=provenance,
        mass=BALL_MASS,
        radius=BALL_RADIUS,
        drag_factor=DRAG_FACTOR,
        magnus_factor=MAGNUS_FACTOR,
        constants={name: value for name, value in named if name not in PLAIN},
        contexts=context_code(),
        hooks=hook_code(simulator),
        quantities=quantity_functions(simulator),
        half_width=TABLE_HALF_WIDTH,
        half_length=TABLE_HALF_LENGTH,
        adaptor=environment.get_template(f"{engine}.jinja").render().rstrip(),
    )
