"""Hypotheses: each number of the catalogue may be the one that the simulator has wrong."""

from dataclasses import dataclass

from models.ball.catalogue import catalogue
from models.ball.effect import Parameter
from models.ball.simulator import Simulator

# Of a parameter's range, for differences: small, since a path has a kink where it bounces, and the
# fewer samples lie between two bounces that are compared the better.
STEP = 5e-6

OTHER_SURFACES = ("net", "racket_bounce")  # shots touch nothing but the table


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

    def nearby(self, simulator: Simulator) -> float:
        """Return another value, a small step away: upwards, unless the range ends there.

        Many laws are clipped at a bound, and a step across it would see none of their slope.
        """
        value, step = self.value(simulator), self.step
        return value + step if value + step <= self.declaration.bounds[1] else value - step


def hypotheses(simulator: Simulator) -> tuple[Hypothesis, ...]:
    """Return every number of the catalogue that a small change of ``simulator`` can reach.

    Effects that have no neutral value, such as surfaces that are not there, cannot be reached, and
    of surfaces that no shot touches there is nothing to find out.
    """
    return tuple(
        Hypothesis(effect.name, parameter.name)
        for effect in catalogue().values()
        if effect.name not in OTHER_SURFACES
        if effect.name in simulator.effects or not any(p.required for p in effect.parameters)
        for parameter in effect.parameters
    )
