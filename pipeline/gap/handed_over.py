"""What a verdict gives back for a scene of MuJoCo."""

from typing import TYPE_CHECKING

from rallygap.models.gap.amend.simulator import amended, amended_yaml
from rallygap.pipeline.engines.export.code import ball_effects
from rallygap.pipeline.engines.export.command import comments_of
from rallygap.pipeline.gap.summary import Findings

if TYPE_CHECKING:
    from rallygap.pipeline.engines.export.scene.amended_scene import AmendedScene


def handed_over(findings: Findings, minor: bool) -> "AmendedScene":
    """Return the scene of a verdict amended, and code for it, both verified.

    A scene that cannot be amended is no error: then there is the code, and a sentence says why.

    Args:
        findings: on a scene of MuJoCo.
        minor: whether minor structure is amended as well.

    Raises:
        InputError: the scene cannot be read.
    """
    from rallygap.pipeline.engines.export.scene.amended_scene import amended_scene

    name, before = findings.simulator_name, findings.simulator
    comments = comments_of(amended_yaml(before, findings.verdict, findings.measured.name, minor))
    after = amended(before, findings.verdict, minor)
    code = ball_effects(after, "amended.yaml", comments, "mujoco")
    return amended_scene(name, before, after, code, comments)
