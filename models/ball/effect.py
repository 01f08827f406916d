"""Effects: a name, an equation, parameters and the changed quantities of the model.

An effect does not integrate or collide a ball. It adds to one of the *quantities* in which the
equations of motion, the contact laws and the sensor are written (``quantities.py``), or scales it.
So effects combine in any number and order, and one compilation serves every combination.
"""

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, Literal

Hook = Callable[..., Any]


@dataclass(frozen=True)
class Parameter:
    """One parameter of an effect.

    Attributes:
        name: as written in a simulator's YAML.
        unit: SI unit, ``1`` for none.
        neutral: the value at which the effect changes nothing. A neutral value outside ``bounds``
            means that the parameter has no default and must be given.
        bounds: smallest and largest plausible value.
        observed: values in real set-ups.
        source: of the equation and the numbers.
    """

    name: str
    _: KW_ONLY
    unit: str = "1"
    neutral: float = 0.0
    bounds: tuple[float, float]
    observed: str
    source: str = "definition"

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
    """A physical or measurement effect.

    Attributes:
        name: identifier in YAML files, verdicts and reports.
        title: what happens, in a few words.
        equation: its exact form.
        acts: where it acts.
        parameters: in the order of the arguments of the hooks.
        table: names of the columns of its table, whose rows are given as ``nodes``; empty without.
        changes: filled by the decorators ``adds`` and ``scales``.
    """

    name: str
    title: str
    equation: str
    acts: Literal["flight", "contact", "sensor"]
    parameters: tuple[Parameter, ...]
    table: tuple[str, ...] = ()
    changes: list[Change] = field(default_factory=list, compare=False)

    def parameter(self, name: str) -> Parameter:
        """Return the parameter of a name."""
        return next(parameter for parameter in self.parameters if parameter.name == name)

    def adds(self, quantity: str) -> Callable[[Hook], Hook]:
        """Decorate ``hook(context, *parameters)``, whose value is added to ``quantity``.

        Hooks of quantities without a context, such as ``wind``, take the parameters alone. The hook
        is compiled by numba (hooks of sensor quantities stay numpy). It returns a number, or a
        tuple where the quantity is a vector. The rows of a table come last.
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
