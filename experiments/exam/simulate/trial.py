"""A trial: everything that its recordings follow from."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from experiments.exam.simulate.camera_errors import CameraErrors
from rallygap.models.arena.bounce_scatter import BounceScatter
from rallygap.models.arena.cameras import Cameras, SlowError
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.gap.hypotheses import Hypothesis

Dynamics = Literal["catalogue", "independent"]
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
NO_ERRORS = CameraErrors()


@dataclass(frozen=True)
class Variation:
    """How the value of one hidden parameter varies.

    - ``drift``: linearly over the session, from nominal at the first shot; its mean is the value
      of the cause.
    - ``shot``: normally from shot to shot, around the value of the cause.
    - ``place``: the cause acts where y > 0, and nowhere else.
    """

    kind: Literal["drift", "shot", "place"]
    parameter: Hypothesis
    spread: float = 0.0  # of kind ``shot``: standard deviation, as a share of the value

    def values(
        self, nominal: float, value: float, shots: int, random: np.random.Generator
    ) -> Floats:
        """Return (shots,) values of the parameter, within its bounds."""
        if self.kind == "drift":
            values = nominal + (value - nominal) * np.linspace(0.0, 2.0, shots)
        else:
            values = value * (1.0 + self.spread * random.standard_normal(shots))
        return np.clip(values, *self.parameter.declaration.bounds)


@dataclass(frozen=True)
class Trial:
    """One trial of the exam."""

    name: str  # unique in the exam
    nominal: Simulator  # the simulator that methods are given
    # what is hidden, effect name -> parameter name -> true value
    causes: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    # where the nominal simulator is far off: effect name -> parameter name -> true value
    far_off: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    variation: Variation | None = None  # of a cause that is not the same throughout the session
    # the catalogue's equations, or the independent ones (independent_ball)
    dynamics: Dynamics = "catalogue"
    shots: int = 100  # how many are recorded
    directions: Literal[1, 2] = 2  # 1 (all towards -y) or 2
    spin_labels: SpinLabels = "per_row"  # none, one a shot at its first frame, or one in every row
    cameras: Cameras = CAMERAS  # noise, outliers, dropouts and frame interval
    errors: CameraErrors = NO_ERRORS  # of the sensor, beyond those of `cameras`
    # of the time stamps in s, 0 if they are exact; detection limits leave it out
    time_resolution: float = 0.0
    scatter: BounceScatter = SCATTER  # standard deviations of the bounces' restitution and friction
    withheld: tuple[str, ...] = ()  # effects that are removed from the methods' catalogue
    seed: int = 0  # of every random draw

    @property
    def base(self) -> Simulator:
        """The nominal simulator, with true values where it is far off."""
        return _amended(self.nominal, self.far_off)

    @property
    def simulator(self) -> Simulator:
        """The base with the hidden causes, in the catalogue's forms."""
        return _amended(self.base, self.causes)

    @property
    def without_causes(self) -> "Trial":
        """The trial of an environment that equals the base, which is also its nominal simulator."""
        return replace(
            self, nominal=self.base, far_off={}, causes={}, variation=None, dynamics="catalogue"
        )


def _amended(simulator: Simulator, causes: Mapping[str, Mapping[str, float]]) -> Simulator:
    for effect, parameters in causes.items():
        simulator = simulator.amended(effect, **parameters)
    return simulator
