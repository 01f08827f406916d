"""A trial: everything that its recordings follow from."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from models.arena.bounce_scatter import BounceScatter
from models.arena.cameras import Cameras, SlowError
from models.ball.simulator import Simulator

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


@dataclass(frozen=True)
class Trial:
    """One trial of the exam."""

    name: str  # unique in the exam
    nominal: Simulator  # the simulator that methods are given
    # what is hidden, effect name -> parameter name -> true value
    causes: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    # the catalogue's equations, or the independent ones (independent_ball)
    dynamics: Dynamics = "catalogue"
    shots: int = 100  # how many are recorded
    directions: Literal[1, 2] = 2  # 1 (all towards -y) or 2
    spin_labels: SpinLabels = "per_row"  # none, one a shot at its first frame, or one in every row
    cameras: Cameras = CAMERAS  # noise, outliers, dropouts and frame interval
    time_resolution: float = 0.0  # of the time stamps in s, 0 if they are exact
    scatter: BounceScatter = SCATTER  # standard deviations of the bounces' restitution and friction
    withheld: tuple[str, ...] = ()  # effects that are removed from the methods' catalogue
    seed: int = 0  # of every random draw

    @property
    def simulator(self) -> Simulator:
        """The nominal simulator with the hidden causes, in the catalogue's forms."""
        simulator = self.nominal
        for effect, parameters in self.causes.items():
            simulator = simulator.amended(effect, **parameters)
        return simulator
