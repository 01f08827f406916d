"""What a user gets back for a scene: its amended file and ``ball_effects.py``, both verified."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rallygap.models.ball.simulator import Simulator
from rallygap.models.engines.engine import EngineError
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.pipeline.engines.export.code import CODE
from rallygap.pipeline.engines.export.scene.coded_ball import CodedBall
from rallygap.pipeline.engines.export.scene.patch import Patch, patched
from rallygap.pipeline.engines.export.scene.shots import VerificationShots
from rallygap.pipeline.engines.export.scene.source import SceneSource
from rallygap.pipeline.engines.export.scene.tags import Edit, comments_above, tags, with_edits
from rallygap.pipeline.engines.export.scene.unsaid import unsaid
from rallygap.pipeline.engines.export.scene.verification import agreement, scene_sentences
from rallygap.pipeline.engines.export.scene_file import SCENE
from rallygap.pipeline.runtime.errors import InputError

SHARED = ("gravity", "wind", "density", "viscosity")  # attributes that act on all bodies
CONTACT = ("solref", "friction")
BALL_ALONE = 6  # degrees of freedom of a scene whose only moving body is the ball
FILES = ("file", "meshdir", "texturedir", "assetdir")  # attributes that name other files


@dataclass(frozen=True)
class HandedOver:
    """What is given back for a scene.

    Attributes:
        scene: text of the amended file; None where the scene cannot be patched.
        code: content of ``ball_effects.py``.
        sentences: what is changed, what is not said, and what the verification shows.
    """

    scene: str | None
    code: str
    sentences: tuple[str, ...]


def handed_over(
    name: str, before: Simulator, after: Simulator, code: str, comments: Sequence[str]
) -> HandedOver:
    """Return a scene amended, and code for it, both verified.

    Args:
        name: of the scene, ``scene.xml`` or ``scene.xml#body``.
        before: what the scene does.
        after: what it is to do.
        code: content of ``ball_effects.py`` for MuJoCo, of ``after``.
        comments: of the list, on where changed values come from.

    Raises:
        InputError: the scene cannot be patched, read or flown.
    """
    source = SceneSource.read(name)
    shots = VerificationShots.of(after)
    try:
        patch = patched(source, before, after, comments)
        about = [
            *_about(source.path, patch),
            *unsaid(patch.scene, before, after, shots),
            *scene_sentences(patch.scene, after, shots, SCENE),
        ]
        checked = _code_sentences(source.scene(), after, code, shots)
        return HandedOver(_with_head(patch.source.text, about), code, (*about, *checked))
    except EngineError as error:
        raise InputError(source.path, str(error)) from None


def without_scene(name: str, after: Simulator, code: str, problem: InputError) -> HandedOver:
    """Return what is given back for a scene that cannot be patched: verified code, and why.

    Raises:
        InputError: the scene cannot be read.
    """
    scene = SceneSource.read(name).scene()
    checked = _code_sentences(scene, after, code, VerificationShots.of(after))
    return HandedOver(None, code, (f"There is no amended {SCENE}: {problem}.", *checked))


def _code_sentences(
    scene: MujocoScene, after: Simulator, code: str, shots: VerificationShots
) -> tuple[str, ...]:
    ball, step = CodedBall(CODE, code, scene), float(scene.model.opt.timestep)
    found = agreement(ball, after, shots.some(), step, scene.frame.found)
    return tuple(found.sentences(CODE))


def _about(path: Path, patch: Patch) -> Iterator[str]:
    """Yield what is changed, and what else that changes."""
    changes = patch.changes
    yield f"Changed attributes of {path.name}: {', '.join(changes) or 'none'}."
    shared = [one for one in changes if one in SHARED]
    if shared and patch.scene.model.nv > BALL_ALONE:
        yield f"All bodies of the scene meet {', '.join(shared)}, not only the ball."
    if set(changes) & set(CONTACT) and not patch.scene.model.npair:
        yield "The contact's attributes belong to geoms, which meet all other things with them too."
    if any(set(tag.attributes) & set(FILES) for tag in tags(patch.source.text)):
        yield f"{SCENE} belongs into the folder of {path.name}: its paths are relative to it."


def _with_head(text: str, about: Sequence[str]) -> str:
    """Return a text with comments above its first element."""
    root = next(tags(text))
    comments = comments_above(text, root.start, [f"rallygap: {one}" for one in about])
    return with_edits(text, [Edit(root.start, root.start, comments)])
