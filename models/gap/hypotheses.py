"""Hypotheses: each parameter of the catalogue may have another value than the simulator's.

A hypothesis is identified by its effect and parameter, written ``effect.parameter`` everywhere:
``drag.cd``, ``wind.x``, ``table_bounce.restitution``.
"""

import difflib
from dataclasses import dataclass

from rallygap.models.ball.catalogue import catalogue, parameter_columns
from rallygap.models.ball.effect import Parameter
from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.types import Phase

# Share of a parameter's range, for finite differences. It is small because a path has a kink where
# it bounces: the fewer samples lie between the two bounces that are compared, the better.
STEP = 5e-6

AXES = ("x", "y", "z")  # parameters of these names are components of a vector
PHASE_OF: dict[str, Phase] = {"flight": "flight", "contact": "table", "sensor": "sensor"}
OTHER_SURFACES = ("net", "racket_bounce")  # shots touch nothing but the table


@dataclass(frozen=True)
class Hypothesis:
    """One parameter of one effect: its value may differ from the simulator's."""

    effect: str
    parameter: str

    @classmethod
    def from_identity(cls, identity: str) -> "Hypothesis":
        """Return the hypothesis about a parameter of the catalogue, such as ``wind.x``.

        Raises:
            ValueError: the catalogue has no such parameter.
        """
        known = {f"{effect}.{parameter}" for effect, parameter in parameter_columns()}
        if identity not in known:
            near = difflib.get_close_matches(identity, sorted(known), n=1)
            hint = f"; did you mean {near[0]}?" if near else ""
            raise ValueError(f"the catalogue has no parameter {identity!r}{hint}")
        return cls(*identity.split("."))

    @property
    def identity(self) -> str:
        """``effect.parameter``."""
        return f"{self.effect}.{self.parameter}"

    @property
    def quantity(self) -> str:
        """The physical quantity: the components of a vector, such as the wind's, are one."""
        return self.effect if self.parameter in AXES else self.identity

    @property
    def phase(self) -> Phase:
        """The phase in which the effect acts."""
        return PHASE_OF[catalogue()[self.effect].acts]

    @property
    def declaration(self) -> Parameter:
        """The catalogue's entry of the parameter."""
        parameters = catalogue()[self.effect].parameters
        return next(one for one in parameters if one.name == self.parameter)

    @property
    def step(self) -> float:
        """A small change, in the parameter's unit."""
        low, high = self.declaration.bounds
        return STEP * (high - low)

    def value(self, simulator: Simulator) -> float:
        """Return the value that ``simulator`` has, neutral where it lacks the effect."""
        values = simulator.effects.get(self.effect, {})
        return float(values.get(self.parameter, self.declaration.neutral))

    def is_neutral(self, value: float) -> bool:
        """Whether a value is that of an effect that is absent."""
        return value == self.declaration.neutral

    def is_bound(self, value: float) -> bool:
        """Whether a value is at a bound of the plausible range; the neutral value never is."""
        return value in self.declaration.bounds and not self.is_neutral(value)

    def listed(self, simulator: Simulator) -> bool:
        """Whether ``simulator`` lists the effect (a wrong value if so, else a missing effect)."""
        return self.effect in simulator.effects

    def at(self, simulator: Simulator, value: float) -> Simulator:
        """Return ``simulator`` with another value, appended where it lacked the effect."""
        return simulator.amended(self.effect, **{self.parameter: value})

    def nearby(self, simulator: Simulator) -> float:
        """Return another value, a small step away: upwards, unless the range ends there.

        Many laws are clipped at a bound: a step across it would miss part of their slope.
        """
        value, step = self.value(simulator), self.step
        return value + step if value + step <= self.declaration.bounds[1] else value - step


def hypotheses(simulator: Simulator) -> tuple[Hypothesis, ...]:
    """Return every parameter of the catalogue that a small change of ``simulator`` can reach.

    Left out are effects without a neutral value that the simulator lacks, such as a missing
    surface, surfaces that no shot of the gap workflow touches, and effects with a table, which are
    not a matter of one number.
    """
    return tuple(
        Hypothesis(effect.name, parameter.name)
        for effect in catalogue().values()
        if effect.name not in OTHER_SURFACES and not effect.table
        if effect.name in simulator.effects or not any(p.required for p in effect.parameters)
        for parameter in effect.parameters
    )


# The share of spin labels that are read with the wrong sign: a fault of the sensor that is decided
# shot by shot (name/label_readings.py), not by a derivative.
LABEL_SIGNS = Hypothesis("spin_sign_flip", "share")
