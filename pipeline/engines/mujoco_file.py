"""Scenes of MuJoCo from their files."""

from pathlib import Path
from typing import TYPE_CHECKING

from rallygap.models.engines.engine import EngineError
from rallygap.pipeline.runtime.errors import InputError

if TYPE_CHECKING:
    from rallygap.models.engines.mujoco.scene import MujocoScene


def load_scene(path: Path | str, ball: str | None = None) -> "MujocoScene":
    """Read a scene from its MJCF file.

    Args:
        path: of the file.
        ball: name of the ball's body; None to find it.

    Raises:
        InputError: MuJoCo is not installed or cannot read the file, or the scene has no ball.
    """
    try:
        import mujoco

        from rallygap.models.engines.mujoco.scene import MujocoScene
    except ImportError as error:
        advice = "pip install -e '.[mujoco]' brings MuJoCo, which flies this scene"
        raise InputError(path, f"{advice} ({_one_line(error)})") from None
    if not Path(path).is_file():
        raise InputError(path, "there is no such file")
    try:
        return MujocoScene.of(Path(path).stem, mujoco.MjModel.from_xml_path(str(path)), ball)
    except EngineError as error:
        raise InputError(path, str(error)) from None
    except (ValueError, mujoco.FatalError) as error:
        raise InputError(path, f"MuJoCo cannot read it: {_one_line(error)}") from None


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())
