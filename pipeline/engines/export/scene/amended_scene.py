"""What a user gets for a scene: its amended file and ``ball_effects.py``, both verified."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.simulator import Simulator
from rallygap.models.engines.engine import EffectsEngine, EngineError
from rallygap.models.engines.mujoco.ball import SHELL, has_inertia
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.pipeline.engines.export.code import CODE, SCENE
from rallygap.pipeline.engines.export.code_engine import CodeEngine
from rallygap.pipeline.engines.export.scene.amendment import Amendment, SceneFile, amend
from rallygap.pipeline.engines.export.scene.contact import TABLE
from rallygap.pipeline.engines.export.scene.flight import differs, flight_numbers
from rallygap.pipeline.engines.export.scene.verification import (
    AFTER,
    BEFORE,
    FLIGHT,
    VerificationShots,
    agreement,
    distances,
    scene_sentences,
)
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.web.numbers import number, with_unit

SHARED = ("gravity", "wind", "density", "viscosity")  # attributes that act on all bodies
CONTACT = ("solref", "friction")
BALL_ALONE = 6  # degrees of freedom of a scene whose only moving body is the ball
# Effects that have attributes; those of "table_bounce" are a matter of the verification.
STATED = {
    "gravity", "frame_tilt", "buoyancy", "added_mass", "wind", "drag", "magnus", "linear_drag",
    TABLE,
}  # fmt: skip
ELSEWHERE = {
    "table_height": "move the geom of the table by it",
    "table_tilt": "turn the geom of the table by it",
    "net": "it belongs to the geom of the net, which remains",
    "racket_bounce": "it belongs to the geom of the racket, which remains",
}
SMALLEST_MM = 0.05  # a cost that is worth a sentence
SAME_DRAG = 1e-4  # 1/s


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


def unsupported(
    scene: MujocoScene, before: Simulator, after: Simulator, shots: VerificationShots
) -> Iterator[str]:
    """Yield what a list changes and no attribute of an amended scene states, in sentences.

    The cost of an effect is the largest distance over the shots.
    """
    for effect in after.effects:
        if effect in STATED or catalogue()[effect].acts == "sensor":
            continue
        parameters = [Hypothesis(effect, own.name) for own in catalogue()[effect].parameters]
        changed = [own for own in parameters if differs(own.value(before), own.value(after))]
        cost = _cost(effect, after, shots) if changed else 0.0
        if cost > SMALLEST_MM or (changed and effect in ELSEWHERE):
            values = ", ".join(
                f"{own.identity} {with_unit(own.value(after), own.declaration.unit)}"
                for own in changed
            )
            hint = f" ({ELSEWHERE[effect]})" if effect in ELSEWHERE else ""
            in_flight = catalogue()[effect].acts == "flight"
            place = f"after {FLIGHT:g} s of flight" if in_flight else f"{AFTER:g} s after a bounce"
            size = f"; without it the ball is up to {cost:.3g} mm off {place}" if cost else ""
            yield f"No attribute here says {values}{hint}{size}."
    yield from _viscosity(scene, before, after)
    if TABLE in after.effects and not has_inertia(scene.model, scene.ball, SHELL):
        yield (
            "The ball is no shell, whose inertia is 2/3 m r^2: its <inertial> or another geom says "
            "otherwise, so its grip at the table differs."
        )


def _cost(effect: str, after: Simulator, shots: VerificationShots) -> float:
    """Return the largest distance, mm, that a list makes without an effect."""
    rest = {name: values for name, values in after.effects.items() if name != effect}
    full, reduced = (EffectsEngine("list", simulator) for simulator in (after, Simulator(rest)))
    if catalogue()[effect].acts == "flight":
        return float(distances(full, reduced, shots.flights, FLIGHT).max())
    return float(distances(full, reduced, shots.bounces, BEFORE + AFTER).max())


def _viscosity(scene: MujocoScene, before: Simulator, after: Simulator) -> Iterator[str]:
    known, wanted = (flight_numbers(law.effects)["linear"] for law in (before, after))
    if not differs(known, wanted):
        return
    damped = float(scene.model.dof_damping[scene.ball.velocity]) / scene.ball.mass
    if wanted < damped - SAME_DRAG:
        yield (
            f"linear_drag.k1 {number(wanted)} 1/s is less than the {number(damped)} 1/s of the "
            "free joint's damping, or below 0; viscosity is 0."
        )
    elif wanted > damped + SAME_DRAG:
        yield (
            f"Viscosity, which says linear_drag.k1, also slows spin, by {number(2.0 * wanted)} of "
            "it per second."
        )
