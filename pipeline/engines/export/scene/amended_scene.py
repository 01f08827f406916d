"""What a user gets for a scene: its amended file and ``ball_effects.py``, both verified."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rallygap.models.ball.simulator import Simulator
from rallygap.models.engines.engine import EngineError
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.pipeline.engines.export.code import CODE, SCENE
from rallygap.pipeline.engines.export.code_engine import CodeEngine
from rallygap.pipeline.engines.export.scene.amendment import Amendment, SceneFile, amend
from rallygap.pipeline.engines.export.scene.unsupported import unsupported
from rallygap.pipeline.engines.export.scene.verification import (
    VerificationShots,
    agreement,
    scene_sentences,
)
from rallygap.pipeline.runtime.errors import InputError

SHARED = ("gravity", "wind", "density", "viscosity")  # attributes that act on all bodies
CONTACT = ("solref", "friction")
BALL_ALONE = 6  # degrees of freedom of a scene whose only moving body is the ball


@dataclass(frozen=True)
class AmendedScene:
    """What is given back for a scene.

    Attributes:
        text: of the amended file; None where the scene cannot be amended.
        code: content of ``ball_effects.py``.
        sentences: what is changed, what has no attribute, and what the verification shows.
        problem: why there is no text.
    """

    text: str | None
    code: str
    sentences: tuple[str, ...]
    problem: InputError | None = None


def amended_scene(
    name: str, before: Simulator, after: Simulator, code: str, comments: Sequence[str]
) -> AmendedScene:
    """Return a scene amended, and code for it, both verified.

    Args:
        name: of the scene, ``scene.xml`` or ``scene.xml#body``.
        before: what the scene does.
        after: what it is to do.
        code: content of ``ball_effects.py`` for MuJoCo, of ``after``.
        comments: of the list, on where changed values come from.

    Raises:
        InputError: the scene cannot be read.
    """
    file, shots = SceneFile.read(name), VerificationShots.of(after)
    scene = file.scene()
    ball, step = CodeEngine(CODE, code, scene), float(scene.model.opt.timestep)
    checked = agreement(ball, after, shots.some(), step, scene.frame.found).sentences(CODE)
    try:
        amendments = amend(file, before, after, comments)
        written = file.written()
        about = [
            *_about(file, written, amendments),
            *unsupported(written, before, after, shots),
            *scene_sentences(written, after, shots, SCENE),
        ]
        text = file.text([*(amendment.sentence for amendment in amendments), *about])
    except (EngineError, InputError) as error:
        problem = error if isinstance(error, InputError) else InputError(file.path, str(error))
        sentences = (f"There is no amended {SCENE}: {problem}.", *checked)
        return AmendedScene(None, code, sentences, problem)
    return AmendedScene(text, code, (*about, *checked))


def _about(file: SceneFile, scene: MujocoScene, amendments: Sequence[Amendment]) -> Iterator[str]:
    """Yield what is changed, and what else that changes."""
    names = list(dict.fromkeys(amendment.attribute for amendment in amendments))
    yield f"Changed attributes of {file.path.name}: {', '.join(names) or 'none'}."
    shared = [name for name in names if name in SHARED]
    if shared and scene.model.nv > BALL_ALONE:
        yield f"All bodies of the scene meet {', '.join(shared)}, not only the ball."
    if set(names) & set(CONTACT) and not scene.model.npair:
        yield "The contact's attributes belong to geoms, which meet all other things with them too."
    source = file.path.read_bytes()
    if b"<include" in source or source.count(b"<!--") > bool(file.comment):
        yield (
            f"MuJoCo writes {SCENE}: it has what {file.path.name} includes, and none of its "
            "comments but one at the start of <mujoco>."
        )
    spec = file.spec
    assets = [*spec.meshes, *spec.textures, *spec.hfields, *spec.skins]
    if any(asset.file for asset in assets):
        yield (
            f"{SCENE} belongs into the folder of {file.path.name}: its paths are relative to it."
        )
