"""The hidden physics of the arena and its hidden measurement errors, drawn by the seed."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from rallygap.models.arena.bounce_scatter import BounceScatter
from rallygap.models.arena.cameras import CameraField, SlowError
from rallygap.models.ball.quantities import TYPICAL_IMPACT, TYPICAL_SPIN_RATIO
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.simulators import shipped

STREAM = 1_000_000  # random stream of the truth, apart from those of the recordings


@dataclass(frozen=True)
class Truth:
    """The hidden physics and measurement errors of the arena."""

    simulator: Simulator  # mean behaviour of ball, table and net
    scatter: BounceScatter  # random deviations of bounces
    slow_error: SlowError  # the part of the cameras' error that changes slowly
    camera_field: CameraField  # the systematic part, a function of the position
    arc_spin_noise: float  # standard deviation of the labels' error on an arc, share of the spin

    def to_dict(self) -> dict[str, Any]:
        """Return a description that can be written as JSON."""
        return {
            "simulator": self.simulator.to_dict(),
            "scatter": asdict(self.scatter),
            "slow_error": asdict(self.slow_error),
            "camera_field": asdict(self.camera_field),
            "arc_spin_noise": self.arc_spin_noise,
        }

    @classmethod
    def from_dict(cls, description: Mapping[str, Any]) -> "Truth":
        """Build it from what ``to_dict`` returns."""
        return cls(
            Simulator.from_dict(description["simulator"]),
            BounceScatter(**description["scatter"]),
            SlowError(**description["slow_error"]),
            CameraField(**description["camera_field"]),
            description["arc_spin_noise"],
        )


def draw_truth(seed: int, physics: str | None = None) -> Truth:
    """Draw the hidden physics and measurement errors of the arena.

    ``physics`` names a shipped simulator that flies the balls instead of the drawn physics; if it
    has no net, the drawn net is added.

    All ranges of the physics are those of real set-ups (``observed`` in the catalogue of effects).
    Effects that no shipped simulator has are always present and never small, so that the truth
    differs from every shipped simulator in several effects.

    Raises:
        SimulatorError: there is no shipped simulator named ``physics``.
    """
    random = np.random.default_rng([seed, STREAM])
    scatter = BounceScatter(
        restitution=_between(random, 0.010, 0.015), friction=_between(random, 0.03, 0.06)
    )
    slow_error = SlowError(share=_between(random, 0.2, 0.5), time=_between(random, 0.03, 0.10))
    effects = _effects(random)
    # Coefficients without spin or at no speed are replaced by those of typical balls.
    effects["drag"]["cd"] += TYPICAL_SPIN_RATIO * effects["spin_dependent_drag"]["c"]
    effects["magnus"]["cm"] /= 1 + TYPICAL_SPIN_RATIO * effects["lift_saturation"]["kappa"]
    loss = TYPICAL_IMPACT * effects["speed_dependent_restitution"]["c"]
    effects["table_bounce"]["restitution"] -= loss
    simulator = Simulator.from_dict(effects)
    if physics is not None:
        simulator = Simulator.from_dict({"net": effects["net"], **shipped(physics).to_dict()})
    field = CameraField(
        standard_deviation=_between(random, 0.0012, 0.0018),
        length=_between(random, 0.7, 0.9),
        seed=int(random.integers(2**32)),
    )
    return Truth(simulator, scatter, slow_error, field, arc_spin_noise=_between(random, 0.02, 0.04))


def _effects(random: np.random.Generator) -> dict[str, dict[str, float]]:
    within = partial(_between, random)

    def around(low: float, high: float) -> float:
        return float(random.choice([-1, 1])) * within(low, high)

    return {
        "gravity": {"g": 9.81},
        "drag": {"cd": within(0.42, 0.52)},
        "speed_dependent_drag": {"c": within(-0.06, -0.03)},
        "spin_dependent_drag": {"c": within(0.05, 0.08)},
        "magnus": {"cm": within(0.22, 0.33)},
        "lift_saturation": {"kappa": within(2.0, 5.0)},
        "spin_decay": {"c": within(0.003, 0.006)},
        "wind": {"x": around(0.05, 0.15), "y": around(0.05, 0.15), "z": 0.0},
        "table_bounce": {"restitution": within(0.92, 0.95), "friction": within(0.17, 0.28)},
        "speed_dependent_restitution": {"c": within(0.004, 0.010)},
        "slip_dependent_friction": {"c": within(0.004, 0.012)},
        "table_tilt": {"x": around(0.001, 0.004), "y": around(0.001, 0.004)},
        "table_height": {"h": around(0.001, 0.003)},
        "net": {"restitution": within(0.1, 0.3), "friction": within(0.3, 0.6)},
        "racket_bounce": {
            "restitution": within(0.84, 0.91),
            "speed_loss": within(0.015, 0.025),
            "kp": within(1.8e-3, 2.0e-3),
        },
    }


def _between(random: np.random.Generator, low: float, high: float) -> float:
    return round(float(random.uniform(low, high)), 6)
