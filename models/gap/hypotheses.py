"""Hypotheses: each number of the catalogue may be the one that the simulator has wrong."""

from dataclasses import dataclass

from models.ball.catalogue import catalogue
from models.ball.effect import Parameter
from models.ball.simulator import Simulator

# Of a parameter's range, for differences: small, since a path has a kink where it bounces, and the
# fewer samples lie between two bounces that are compared the better.
STEP = 1e-5


@dataclass(frozen=True)
class Hypothesis:
    """One number of one effect: its value may differ from the simulator's."""

    effect: str
    parameter: str

    @property
    def siblings(self) -> tuple[Parameter, ...]:
        """All parameters of the effect."""
        return catalogue()[self.effect].parameters

    @property
    def declaration(self) -> Parameter:
        """What the catalogue says of the parameter."""
        return next(one for one in self.siblings if one.name == self.parameter)

    @property
    def step(self) -> float:
        """A small change, in the parameter's unit."""
        low, high = self.declaration.bounds
        return STEP * (high - low)

    def value(self, simulator: Simulator) -> float:
        """Return the number that ``simulator`` has, neutral where it lacks the effect."""
        values = simulator.effects.get(self.effect, {})
        return values.get(self.parameter, self.declaration.neutral)

    def listed(self, simulator: Simulator) -> bool:
        """Whether the number is the simulator's own: a wrong value, not a missing effect."""
        return self.effect in simulator.effects

    def at(self, simulator: Simulator, value: float) -> Simulator:
        """Return ``simulator`` with another value, appended where it lacked the effect."""
        return simulator.amended(self.effect, **{self.parameter: value})

    def nodes(self, simulator: Simulator) -> tuple[tuple[float, float], ...]:
        """Return (value, weight) pairs whose weighted predictions add up to the derivative.

        Central differences, and second-order one-sided ones at a bound: many laws are clipped
        there, and a central difference would see half the slope.
        """
        value, h = self.value(simulator), self.step
        low, high = self.declaration.bounds
        if value - h < low:
            return ((value, -1.5 / h), (value + h, 2 / h), (value + 2 * h, -0.5 / h))
        if value + h > high:
            return ((value, 1.5 / h), (value - h, -2 / h), (value - 2 * h, 0.5 / h))
        return ((value - h, -0.5 / h), (value + h, 0.5 / h))


def hypotheses(simulator: Simulator) -> tuple[Hypothesis, ...]:
    """Return every number of the catalogue that a small change of ``simulator`` can reach.

    Effects that have no neutral value, such as surfaces that are not there, cannot be reached.
    """
    return tuple(
        Hypothesis(effect.name, parameter.name)
        for effect in catalogue().values()
        if effect.name in simulator.effects or not any(p.required for p in effect.parameters)
        for parameter in effect.parameters
    )
