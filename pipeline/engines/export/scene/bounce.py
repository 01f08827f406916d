"""The contact of a scene with a restitution and a friction: solved by bounces in the scene.

The formula gives the damping for a contact of many time steps and a constant impedance. In a scene
with other ones the restitution differs, so the damping is corrected by bounces until balls leave as
fast as they do with the list of effects.
"""

import copy
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from scipy.optimize import brentq

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import BALL_RADIUS, STATE_SIZE
from rallygap.models.ball.types import Floats
from rallygap.models.engines.mujoco.contact import PLACE, Contact, restitution, table_contact
from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.pipeline.engines.export.scene.flight import ROUNDING, numbers
from rallygap.pipeline.engines.export.scene.target import differs
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


@dataclass(frozen=True)
class Party:
    """What the attributes of a contact belong to: a geom or a pair of geoms, by its index."""

    kind: str
    index: int


@dataclass(frozen=True)
class ContactChange:
    """An attribute of the contact of ball and table that is to have other numbers.

    Attributes:
        attribute: ``solref``, or ``friction``, of which the spin's numbers remain.
        values: stiffness and damping, negative as MuJoCo has them; or the coefficient of friction.
        parties: to which it belongs.
    """

    attribute: str
    values: tuple[float, ...]
    parties: tuple[Party, ...]

    def written(self, scene: MujocoScene, party: Party) -> str | None:
        """Return the attribute of a party in a scene; None where it has these numbers already."""
        known = _numbers_of(scene.model, self.attribute, party)
        wanted = np.r_[self._slots(party), known[len(self._slots(party)) :]]
        return None if np.allclose(known, wanted, rtol=ROUNDING) else numbers(wanted)

    def applied(self, scene: MujocoScene) -> MujocoScene:
        """Return a scene with this change."""
        model = copy.copy(scene.model)
        for party in self.parties:
            slots = self._slots(party)
            _numbers_of(model, self.attribute, party)[: len(slots)] = slots
        return replace(scene, model=model)

    def holds(self, scene: MujocoScene) -> bool:
        """Return whether the contact of ball and table in a scene has these numbers."""
        found = table_contact(scene.model, scene.ball, scene.frame)
        if found is None:
            return False
        if self.attribute == "solref":
            known, wanted = [-found.stiffness, -found.damping], self.values
        else:  # MuJoCo's friction is never 0
            known, wanted = [found.friction[0]], (max(self.values[0], mujoco.mjMINMU),)
        return bool(np.allclose(known, wanted, rtol=ROUNDING))

    def _slots(self, party: Party) -> tuple[float, ...]:
        """Return the first numbers; a pair has friction along two directions of the table."""
        twice = self.attribute == "friction" and party.kind == "pair"
        return self.values * 2 if twice else self.values


def friction_change(scene: MujocoScene, simulator: Simulator) -> ContactChange | None:
    """Return the change with which the contact has the coefficient of friction of a list.

    How fast slip ends remains as it is.

    Returns:
        None where the contact has it.

    Raises:
        InputError: neither the pair nor the geoms of ball and table make the contact.
    """
    contact, wanted = _contact(scene), float(simulator.effects[TABLE]["friction"])
    if not differs(contact.friction[0], wanted):
        return None
    choices = (ContactChange("friction", (wanted,), parties) for parties in _choices(scene))
    return _first_that_holds(scene, choices)


def restitution_change(scene: MujocoScene, simulator: Simulator) -> ContactChange | None:
    """Return the change with which balls leave the table as fast as with a list.

    The stiffness remains, unless a ball sinks in deeper than ``DEEPEST``.

    Args:
        scene: whose flight is that of the list.
        simulator: the list.

    Returns:
        None where they do.

    Raises:
        InputError: neither the pair nor the geoms of ball and table make the contact.
    """
    if abs(_excess(scene, simulator)) <= KEPT:
        return None
    choices = (_solved(scene, simulator, parties) for parties in _choices(scene))
    return _first_that_holds(scene, choices)


def _first_that_holds(scene: MujocoScene, choices: Iterable[ContactChange]) -> ContactChange:
    for change in choices:
        if change.holds(change.applied(scene)):
            return change
    problem = "neither the pair nor the geoms of ball and table make their contact; check <option>"
    raise InputError(scene.name, problem)


def _numbers_of(model: mujoco.MjModel, attribute: str, party: Party) -> Floats:
    found: Floats = getattr(model, f"{party.kind}_{attribute}")[party.index]
    return found


def _contact(scene: MujocoScene) -> Contact:
    found = table_contact(scene.model, scene.ball, scene.frame)
    assert found is not None  # the caller has looked
    return found


def _choices(scene: MujocoScene) -> Iterator[tuple[Party, ...]]:
    """Yield what the contact may belong to: the pairs, or the ball, or the ball and the table."""
    model, ball, tables = scene.model, scene.ball.geom, scene.frame.geoms
    ends = np.column_stack([model.pair_geom1, model.pair_geom2]).tolist()
    met = [{ball, one} for one in tables]
    pairs = [number for number, pair in enumerate(ends) if set(pair) in met]
    if pairs:
        yield tuple(Party("pair", one) for one in pairs)
        return
    yield (Party("geom", ball),)
    yield tuple(Party("geom", one) for one in (ball, *tables))


def _solved(scene: MujocoScene, simulator: Simulator, parties: tuple[Party, ...]) -> ContactChange:
    """Return a contact with the damping that gives the restitution of a list in this scene."""
    target = float(simulator.effects[TABLE]["restitution"])
    # The fourth digit of a stiffness, and the hundredth of a damping, are enough.
    stiffness = float(f"{_stiffness(scene, target):.4g}")
    tried: list[tuple[float, ContactChange]] = []
    ratio = _ratio(target)
    for _ in range(CORRECTIONS):
        damping = round(2.0 * ratio * math.sqrt(stiffness), 2)
        change = ContactChange("solref", (-stiffness, -damping), parties)
        excess = _excess(change.applied(scene), simulator)
        tried.append((abs(excess), change))
        if abs(excess) < SAME:
            break
        ratio = _ratio(restitution(ratio) - excess)
    return min(tried, key=lambda one: one[0])[1]


def _stiffness(scene: MujocoScene, target: float) -> float:
    known, step = _contact(scene).stiffness, float(scene.model.opt.timestep)
    if TYPICAL_SPEED * math.sqrt(target / known) <= DEEPEST:
        return known
    return max(known, (math.pi / (STEPS * step)) ** 2)


def _ratio(wanted: float) -> float:
    """Return the damping ratio with a restitution, as near as one above zero gets."""
    within = min(max(wanted, restitution(LARGEST_RATIO)), 1.0)
    return float(brentq(lambda ratio: restitution(ratio) - within, 0.0, LARGEST_RATIO))


def _excess(scene: MujocoScene, simulator: Simulator) -> float:
    """Return by how much balls leave a scene's table too fast, over their speed, in the mean."""
    contact = _contact(scene)
    states, speeds = _drops(scene)
    step = float(scene.model.opt.timestep)
    times = np.array([states[:, 2].max() / SPEEDS[0] + 2.0 * contact.duration + 4.0 * step])
    level = {name: one for name, one in simulator.effects.items() if name not in SURFACE}
    known = Simulator(level).fly(_raised(states, BALL_RADIUS), times).states
    flown = scene.fly(_raised(states, scene.ball.radius + contact.lift), times)
    return float(((flown - known)[:, 0, 5] / speeds).mean())


def _drops(scene: MujocoScene) -> tuple[Floats, Floats]:
    """Return (B, 9) states over a table at height 0 for points, and their (B,) speeds, m/s."""
    speeds = np.repeat(SPEEDS, PHASES)
    shares = np.tile(np.arange(PHASES) / PHASES, len(SPEEDS))
    states = np.zeros((len(speeds), STATE_SIZE))
    states[:, 1] = -PLACE * scene.frame.length / 2.0
    states[:, 2] = ABOVE + shares * speeds * scene.model.opt.timestep
    states[:, 5] = -speeds
    return states, speeds


def _raised(states: Floats, height: float) -> Floats:
    raised = states.copy()
    raised[:, 2] += height
    return raised
