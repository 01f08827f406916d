"""The contact of a scene with a restitution and a friction: solved by bounces in the scene.

The formula gives the damping for a contact of many time steps and a constant impedance. In a scene
with other ones the restitution differs, so the damping is corrected by bounces until balls leave as
fast as they do with the list of effects.
"""

import copy
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import mujoco
import numpy as np
from scipy.optimize import brentq

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import BALL_RADIUS, STATE_SIZE
from rallygap.models.engines.mujoco.contact import PLACE, Contact, restitution, table_contact
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.pipeline.engines.export.scene.change import ROUNDING, Change, Element, numbers_of
from rallygap.pipeline.engines.export.scene.flight import differs
from rallygap.pipeline.runtime.errors import InputError

TABLE = "table_bounce"
SURFACE = ("table_height", "table_tilt")  # where the table lies, which is no matter of its contact
SPEEDS = (1.5, 2.5, 3.5, 4.5)  # m/s, of the bounces, normal to the table
PHASES = 8  # of the contact between two time steps
ABOVE = 1e-3  # m, of the nearest first state over the table
TYPICAL_SPEED = 3.0  # m/s
DEEPEST = 5e-3  # m: a contact that is deeper at the typical speed becomes stiffer
STEPS = 10  # of the contact, then
CORRECTIONS = 8
SAME = 5e-4  # of a restitution that is solved for
KEPT = 2e-3  # of a restitution that needs no change
LARGEST_RATIO = 20.0  # of damping, to which a ball does not leave
NOWHERE = "neither the pair nor the geoms of ball and table make their contact; check <option>"


def friction_changes(scene: MujocoScene, simulator: Simulator) -> list[Change]:
    """Return the changes with which the contact has the friction of a list; none where it has it.

    How fast slip ends remains as it is.

    Raises:
        InputError: neither the pair nor the geoms of ball and table make the contact.
    """
    wanted = float(simulator.effects[TABLE]["friction"])
    if not differs(_contact(scene).friction[0], wanted):
        return []
    for elements in _choices(scene):
        changes = [
            # A pair has friction along two directions of the table.
            _change(scene, element, "friction", (wanted,) * (2 if element.kind == "pair" else 1))
            for element in elements
        ]
        friction = _contact(_applied(scene, changes)).friction[0]
        if np.isclose(friction, max(wanted, mujoco.mjMINMU), rtol=ROUNDING):
            return _effective(scene, changes)
    raise InputError(scene.name, NOWHERE)


def restitution_changes(scene: MujocoScene, simulator: Simulator) -> list[Change]:
    """Return the changes with which balls leave the table as fast as with a list; none if they do.

    The stiffness remains, unless a ball sinks in deeper than ``DEEPEST``. The scene's flight is
    that of the list already.

    Raises:
        InputError: neither the pair nor the geoms of ball and table make the contact.
    """
    if abs(_excess(scene, simulator)) <= KEPT:
        return []
    for elements in _choices(scene):
        changes = _solved(scene, simulator, elements)
        contact = _contact(_applied(scene, changes))
        spring = [-contact.stiffness, -contact.damping]
        if np.allclose(spring, changes[0].values, rtol=ROUNDING):
            return _effective(scene, changes)
    raise InputError(scene.name, NOWHERE)


def _choices(scene: MujocoScene) -> Iterator[list[Element]]:
    """Yield what the contact may belong to: the pairs, or the ball, or the ball and the table."""
    model, ball, tables = scene.model, scene.ball.geom, scene.frame.geoms
    ends = np.column_stack([model.pair_geom1, model.pair_geom2]).tolist()
    met = [{ball, table} for table in tables]
    pairs = [Element("pair", number) for number, pair in enumerate(ends) if set(pair) in met]
    if pairs:
        yield pairs
        return
    yield [Element("geom", ball)]
    yield [Element("geom", geom) for geom in (ball, *tables)]


def _change(
    scene: MujocoScene, element: Element, attribute: str, first: tuple[float, ...]
) -> Change:
    """Return the change of the first numbers of an attribute; the others remain."""
    known = numbers_of(scene.model, element, attribute)
    return Change.of(element, attribute, np.r_[first, known[len(first) :]])


def _applied(scene: MujocoScene, changes: Sequence[Change]) -> MujocoScene:
    model = copy.copy(scene.model)
    for change in changes:
        numbers_of(model, change.element, change.attribute)[:] = change.values
    return replace(scene, model=model)


def _effective(scene: MujocoScene, changes: Sequence[Change]) -> list[Change]:
    """Return those changes that a scene does not have yet."""
    known = [numbers_of(scene.model, change.element, change.attribute) for change in changes]
    pairs = zip(changes, known, strict=True)
    return [change for change, now in pairs if not np.allclose(now, change.values, rtol=ROUNDING)]


def _contact(scene: MujocoScene) -> Contact:
    contact = table_contact(scene.model, scene.ball, scene.frame)
    assert contact is not None  # the caller has looked
    return contact


def _solved(scene: MujocoScene, simulator: Simulator, elements: Sequence[Element]) -> list[Change]:
    """Return the contact with the damping that gives the restitution of a list in this scene."""
    target = float(simulator.effects[TABLE]["restitution"])
    stiffness, step = _contact(scene).stiffness, float(scene.model.opt.timestep)
    if TYPICAL_SPEED * math.sqrt(target / stiffness) > DEEPEST:
        stiffness = max(stiffness, (math.pi / (STEPS * step)) ** 2)
    # The fourth digit of a stiffness, and the hundredth of a damping, are enough.
    stiffness = float(f"{stiffness:.4g}")
    tried: list[tuple[float, list[Change]]] = []
    ratio = _ratio(target)
    for _ in range(CORRECTIONS):
        spring = (-stiffness, -round(2.0 * ratio * math.sqrt(stiffness), 2))
        changes = [_change(scene, element, "solref", spring) for element in elements]
        excess = _excess(_applied(scene, changes), simulator)
        tried.append((abs(excess), changes))
        if abs(excess) < SAME:
            break
        ratio = _ratio(restitution(ratio) - excess)
    return min(tried, key=lambda trial: trial[0])[1]


def _ratio(wanted: float) -> float:
    """Return the damping ratio with a restitution, as near as one above zero gets."""
    within = min(max(wanted, restitution(LARGEST_RATIO)), 1.0)
    return float(brentq(lambda ratio: restitution(ratio) - within, 0.0, LARGEST_RATIO))


def _excess(scene: MujocoScene, simulator: Simulator) -> float:
    """Return by how much balls leave a scene's table too fast, over their speed, in the mean."""
    contact, step = _contact(scene), float(scene.model.opt.timestep)
    speeds = np.repeat(SPEEDS, PHASES)
    shares = np.tile(np.arange(PHASES) / PHASES, len(SPEEDS))
    states = np.zeros((len(speeds), STATE_SIZE))  # over a table at height 0 for points
    states[:, 1] = -PLACE * scene.frame.length / 2.0
    states[:, 2] = ABOVE + shares * speeds * step
    states[:, 5] = -speeds
    times = np.array([states[:, 2].max() / SPEEDS[0] + 2.0 * contact.duration + 4.0 * step])
    up = np.eye(STATE_SIZE)[2]
    level = {name: values for name, values in simulator.effects.items() if name not in SURFACE}
    known = Simulator(level).fly(states + BALL_RADIUS * up, times).states
    flown = scene.fly(states + (scene.ball.radius + contact.lift) * up, times)
    return float(((flown - known)[:, 0, 5] / speeds).mean())
