"""Plain scenes of MuJoCo that lists of effects are written into, and the lists of each kind."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.pipeline.simulator_scenes.random_lists import (
    BASE,
    FRICTION,
    LINEAR_DRAG,
    LITTLE_FRICTION,
    Effects,
    Ranges,
    complete_list,
    some_effects,
)

if TYPE_CHECKING:
    from rallygap.pipeline.engines.export.scene.patch import Patch
    from rallygap.pipeline.engines.export.scene.source import SceneSource

STEPS = 10  # of time in a contact: with fewer, the restitution scatters
DAMPING = 0.1  # of the contact as it is, over the root of its stiffness

# A vacuum with a table that lies across the world's axes.
MJCF = """<mujoco>
  <option timestep="{step}" integrator="RK4" cone="elliptic"/>
  <worldbody>
    <geom name="table" type="box" size="1.37 .7625 .0125" pos="1 2 .7475"/>
    <body name="ball" pos="1 2 1.5">
      <freejoint/>
      <geom name="ball" type="sphere" size=".02" mass=".0027"/>
    </body>
  </worldbody>
  <contact>
    <pair geom1="table" geom2="ball" condim="3" solref="-{stiffness:.4g} -{damping:.4g}"
      solreffriction="0 -{slip_damping:.4g}" solimp=".98 .98 .001"/>
  </contact>
</mujoco>
"""


@dataclass(frozen=True)
class Kind:
    """Round trips of one kind.

    Attributes:
        lists: how many.
        step: of the scene, s.
        slip: damping of slip over the root of the contact's stiffness.
        own: ranges of parameters that differ from ``BASE`` or are not in it.
    """

    lists: int
    step: float
    slip: float = 1.0
    own: Ranges = field(default_factory=dict)

    @property
    def contact(self) -> float:
        """How long a contact lasts, s."""
        return STEPS * self.step

    @property
    def ranges(self) -> Ranges:
        """Of all parameters of the lists."""
        return {**BASE, **self.own}

    def effects(self, number: int) -> Effects:
        """Return a random list; the same number gives the same list."""
        random = np.random.default_rng(number)
        return some_effects(random, complete_list(random, self.ranges))

    def source(self) -> "SceneSource":
        """Return the scene, as it is before a list is written into it."""
        from rallygap.pipeline.engines.export.scene.source import SceneSource

        root = math.pi / self.contact
        text = MJCF.format(
            step=self.step,
            stiffness=root**2,
            damping=DAMPING * root,
            slip_damping=self.slip * root,
        )
        return SceneSource(Path("plain.xml"), None, text)

    def before(self) -> Simulator:
        """Return what the scene says. No list has its values, so it needs no audit."""
        from rallygap.models.engines.mujoco.says import says

        return Simulator.from_dict(says(self.source().scene()).effects)

    def written(self, effects: Effects) -> "Patch":
        """Return the scene with a list in its attributes.

        Raises:
            InputError: the scene cannot be patched.
        """
        from rallygap.pipeline.engines.export.scene.patch import patched

        return patched(self.source(), self.before(), Simulator.from_dict(effects), [])


KINDS: Mapping[str, Kind] = {
    "flight and bounce": Kind(16, 1e-4),
    "linear drag": Kind(8, 1e-4, own=LINEAR_DRAG),
    "contact of 2 ms": Kind(8, 2e-4),
    "contact of 4 ms": Kind(8, 4e-4),
    "little friction": Kind(8, 1e-4, own=LITTLE_FRICTION),
    "friction": Kind(4, 1e-4, own=FRICTION),
    "friction, slow grip": Kind(4, 1e-4, slip=0.5, own=FRICTION),
    "friction, fast grip": Kind(4, 1e-4, slip=2.0, own=FRICTION),
    "friction, contact of 0.5 ms": Kind(4, 5e-5, own=FRICTION),
}
