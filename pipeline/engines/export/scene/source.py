"""The text of a scene, and the scene that it is."""

import contextlib
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import mujoco

from rallygap.models.engines.engine import EngineError
from rallygap.models.engines.mujoco.log import collected_warnings
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.pipeline.runtime.errors import InputError


@dataclass(frozen=True)
class SceneSource:
    """The text of a scene, which may differ from its file.

    Attributes:
        path: of the file, in whose folder other files of the scene are.
        ball: name of the ball's body; None to find it.
        text: with the line ends of the file.
    """

    path: Path
    ball: str | None
    text: str

    @classmethod
    def read(cls, name: str) -> "SceneSource":
        """Read ``scene.xml`` or ``scene.xml#body``.

        Raises:
            InputError: the file cannot be read, or is not in UTF-8.
        """
        path, _, ball = name.partition("#")
        try:
            return cls(Path(path), ball or None, Path(path).read_bytes().decode("utf-8"))
        except OSError as error:
            raise InputError(path, f"cannot be read: {error.strerror}") from None
        except UnicodeDecodeError:
            raise InputError(path, "is not in UTF-8; save it so") from None

    def with_text(self, text: str) -> "SceneSource":
        """Return this scene with another text."""
        return replace(self, text=text)

    def scene(self) -> MujocoScene:
        """Return the scene.

        Raises:
            InputError: MuJoCo cannot read it, or it has no ball.
        """
        return self._scene

    @cached_property
    def _scene(self) -> MujocoScene:
        # MuJoCo looks for files of a scene that is given as text in the working directory.
        with contextlib.chdir(self.path.absolute().parent), collected_warnings():
            try:
                model = mujoco.MjModel.from_xml_string(self.text)
                return MujocoScene.of(self.path.stem, model, self.ball)
            except EngineError as error:
                raise InputError(self.path, str(error)) from None
            except (ValueError, mujoco.FatalError) as error:
                problem = f"MuJoCo cannot read it: {' '.join(str(error).split())}"
                raise InputError(self.path, problem) from None
