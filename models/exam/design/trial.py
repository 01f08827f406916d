"""A trial: all that its recordings follow from, and what the candidate may see of it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from models.arena.bounce_scatter import BounceScatter
from models.arena.cameras import Cameras, SlowError
from models.ball.catalogue import catalogue
from models.ball.simulator import Simulator

Floats = NDArray[np.float64]

World = Literal["catalogue", "independent"]
SpinLabels = Literal["none", "per_shot", "per_row"]

CAMERAS = Cameras(
    position_noise=0.003,
    spin_noise=0.05,
    dropouts=0.03,
    outliers=0.01,
    slow_error=SlowError(share=0.2, time=0.05),
    interval=0.005,
)
SCATTER = BounceScatter(restitution=0.01, friction=0.05)


@dataclass(frozen=True)
class HiddenCause:
    """One number in which a hall differs from the nominal simulator.

    Attributes:
        effect: its name in the catalogue.
        parameter: its name in the effect.
        kind: whether the nominal simulator lists the effect.
        nominal: what the nominal simulator says, neutral where it does not list the effect.
        value: the truth; of an independent world what a best fit by the catalogue's form finds.
    """

    effect: str
    parameter: str
    kind: Literal["wrong_value", "missing_effect"]
    nominal: float
    value: float


@dataclass(frozen=True)
class Trial:
    """One trial of the exam.

    Attributes:
        name: unique in the exam.
        nominal: the simulator that the candidate is given.
        causes: what is hidden, effect name -> parameter name -> true value.
        world: whose equations the balls follow.
        shots: how many are recorded.
        directions: 1 (all towards -y) or 2.
        spin_labels: none, one a shot at its first frame, or one in every row.
        cameras: noise, outliers, dropouts and frame interval.
        stamp: resolution of the time stamps in s, 0 if they are exact.
        scatter: by how much every bounce deviates.
        withheld: effects that the candidate's catalogue does not have.
        seed: of all that is random.
    """

    name: str
    nominal: Simulator
    causes: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    world: World = "catalogue"
    shots: int = 100
    directions: Literal[1, 2] = 2
    spin_labels: SpinLabels = "per_row"
    cameras: Cameras = CAMERAS
    stamp: float = 0.0
    scatter: BounceScatter = SCATTER
    withheld: tuple[str, ...] = ()
    seed: int = 0

    @property
    def simulator(self) -> Simulator:
        """The nominal simulator amended by the hidden causes, in the catalogue's forms."""
        simulator = self.nominal
        for effect, parameters in self.causes.items():
            simulator = simulator.amended(effect, **parameters)
        return simulator

    @property
    def hidden(self) -> tuple[HiddenCause, ...]:
        """The hidden causes, one a parameter."""
        return tuple(self._hidden())

    def _hidden(self) -> Iterator[HiddenCause]:
        for effect, parameters in self.causes.items():
            listed = effect in self.nominal.effects
            neutral = {p.name: p.neutral for p in catalogue()[effect].parameters}
            nominal = self.nominal.effects[effect] if listed else neutral
            for name, value in parameters.items():
                kind: Literal["wrong_value", "missing_effect"] = (
                    "wrong_value" if listed else "missing_effect"
                )
                yield HiddenCause(effect, name, kind, nominal[name], value)


@dataclass(frozen=True)
class Recording:
    """What cameras deliver of one shot.

    Attributes:
        times: (N,) s on the cameras' clock, rising.
        positions: (N, 3) m.
        label_times: (L,) s of the spin labels, L = 0 without labels.
        labels: (L, 3) rad/s.
    """

    times: Floats
    positions: Floats
    label_times: Floats
    labels: Floats
