"""What an effect is: a name, an equation, parameters, and the quantities of the ball it changes.

An effect never integrates or collides a ball. It says how it changes one of the *quantities* that
the equations of motion, the contact laws and the sensor are written in (``quantities.py``): it
adds to the quantity or scales it. So effects combine in any number, their order does not matter,
and one compilation serves every combination.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

Hook = Callable[..., Any]


@dataclass(frozen=True)
class Parameter:
    """One number of an effect.

    Attributes:
        name: as people write it in a simulator's YAML.
        unit: SI unit, ``1`` where it has none.
        neutral: the value at which the effect changes nothing. A neutral value outside ``bounds``
            means that the parameter has no default and must be given.
        bounds: least and greatest value that makes physical sense.
        seen: what real set-ups show.
        source: where form and numbers come from.
    """

    name: str
    unit: str
    neutral: float
    bounds: tuple[float, float]
    seen: str
    source: str

    @property
    def required(self) -> bool:
        """Whether a simulator that lists the effect must give this parameter."""
        return not self.bounds[0] <= self.neutral <= self.bounds[1]


@dataclass(frozen=True)
class Change:
    """One change that an effect makes: it ``adds`` to or ``scales`` a quantity by a function."""

    quantity: str
    how: Literal["adds", "scales"]
    function: Hook


@dataclass(frozen=True)
class Effect:
    """A physical or measurement effect under the name that people use for it.

    Attributes:
        name: identifier in YAML files, verdicts and reports.
        title: what happens, in a few words.
        equation: its exact form.
        acts: where it acts.
        parameters: its numbers, in the order in which the hooks take them.
        changes: filled by the decorators ``adds`` and ``scales``.
    """

    name: str
    title: str
    equation: str
    acts: Literal["flight", "contact", "sensor"]
    parameters: tuple[Parameter, ...]
    changes: list[Change] = field(default_factory=list, compare=False)

    def adds(self, quantity: str) -> Callable[[Hook], Hook]:
        """Decorate ``hook(context, *parameters)``, whose value is added to ``quantity``.

        The hook is compiled by numba (hooks of sensor quantities stay numpy). It returns a number,
        or a tuple where the quantity is a vector.
        """
        return self._register(quantity, "adds")

    def scales(self, quantity: str) -> Callable[[Hook], Hook]:
        """Decorate ``hook(context, *parameters)``, by whose value ``quantity`` is multiplied."""
        return self._register(quantity, "scales")

    def _register(self, quantity: str, how: Literal["adds", "scales"]) -> Callable[[Hook], Hook]:
        def register(hook: Hook) -> Hook:
            self.changes.append(Change(quantity, how, hook))
            return hook

        return register
