"""The ball simulator: a list of named effects with their parameters."""

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rallygap.models.ball.catalogue import catalogue, parameter_columns
from rallygap.models.ball.effect import Change, Effect, Parameter
from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Floats, Integers
from rallygap.models.support.suggestion import suggestion
from rallygap.models.support.yaml_file import YamlFileError, load_yaml

NODES = "nodes"  # the rows of an effect's table


class SimulatorError(ValueError):
    """An unknown effect or parameter, or an impossible value.

    Args:
        problem: what is wrong and what is allowed, naming effect and parameter.
        path: of the simulator's file, if it is from one.
    """

    def __init__(self, problem: str, path: Path | str | None = None) -> None:
        super().__init__(problem if path is None else f"{path}: {problem}")
        self.problem = problem


@dataclass(frozen=True)
class Contacts:
    """Contacts of the balls of a roll-out, at most ``K`` per ball.

    Attributes:
        count: (B,) contacts of each ball; those beyond K happened but are not recorded.
        time: (B, K) s, NaN beyond the last contact.
        surface: (B, K) ``TABLE``, ``NET`` or ``NONE`` of ``contact_laws``.
        before: (B, K, 9) states just before.
        after: (B, K, 9) states just after.
    """

    count: Integers
    time: Floats
    surface: Integers
    before: Floats
    after: Floats


@dataclass(frozen=True)
class Flight:
    """The roll-out of B balls at T times: ``states`` (B, T, 9) and their ``contacts``."""

    states: Floats
    contacts: Contacts


@dataclass(frozen=True)
class Simulator:
    """A ball simulator: effect name -> parameter name -> value, complete and validated.

    An effect with a table has its rows under ``nodes``.
    """

    effects: Mapping[str, Mapping[str, Any]]

    @classmethod
    def from_dict(cls, description: Mapping[str, Any]) -> "Simulator":
        """Build a simulator from the content of its YAML.

        A parameter that is left out takes its neutral value, where it has one.

        Raises:
            SimulatorError: naming the effect, the parameter and what is allowed.
        """
        if not isinstance(description, Mapping):
            raise SimulatorError("a simulator is a list of effects, each with its parameters")
        return cls({name: _checked(name, values) for name, values in description.items()})

    @classmethod
    def load(cls, path: Path | str) -> "Simulator":
        """Read a simulator from a YAML file: a list of effects, each with its parameters.

        Raises:
            SimulatorError: naming the file, the effect, the parameter and what is allowed.
        """
        try:
            return cls.from_dict(load_yaml(Path(path)))
        except SimulatorError as error:
            raise SimulatorError(error.problem, path) from None
        except YamlFileError as error:
            raise SimulatorError(str(error), path) from None

    def to_dict(self) -> dict[str, dict[str, Any]]:
        """Return what ``from_dict`` takes, every parameter spelled out."""
        return {name: dict(values) for name, values in self.effects.items()}

    def amended(self, effect: str, **parameters: Any) -> "Simulator":
        """Return this simulator with an effect appended, or with some of its values changed.

        Raises:
            SimulatorError: an unknown effect or parameter, or a value that is not allowed.
        """
        current = {**self.effects.get(effect, {}), **parameters}
        return Simulator.from_dict({**self.effects, effect: current})

    def with_values(self, values: Mapping[tuple[str, str], float]) -> "Simulator":
        """Return this simulator with other values, by effect and parameter.

        They are clipped to their bounds; effects that it lacks are appended.
        """
        effects = self.to_dict()
        for (effect, parameter), value in values.items():
            within = np.clip(value, *catalogue()[effect].parameter(parameter).bounds)
            effects.setdefault(effect, {})[parameter] = float(within)
        return Simulator.from_dict(effects)

    def without_surfaces(self) -> "Simulator":
        """Return this simulator with its effects of flight only."""
        flight = {n: p for n, p in self.effects.items() if catalogue()[n].acts == "flight"}
        return Simulator(flight)

    @cached_property
    def vector(self) -> Floats:
        """Parameters of all effects of the catalogue, neutral where an effect is not listed."""
        vector = np.empty(len(parameter_columns()))
        for (effect, parameter), column in parameter_columns().items():
            neutral = catalogue()[effect].parameter(parameter).neutral
            vector[column] = self.effects.get(effect, {}).get(parameter, neutral)
        return vector

    @cached_property
    def sensor_changes(self) -> dict[str, list[tuple[Change, list[Any]]]]:
        """What the listed effects change of the sensor, by quantity, with their parameters.

        Terms that are added come first.
        """
        changes: dict[str, list[tuple[Change, list[Any]]]] = {}
        for name, effect in catalogue().items():
            if effect.acts == "sensor" and name in self.effects:
                values = [np.asarray(value) for value in self.effects[name].values()]
                for change in effect.changes:
                    changes.setdefault(change.quantity, []).append((change, values))
        return {
            quantity: sorted(terms, key=lambda term: term[0].how)
            for quantity, terms in changes.items()
        }

    def fly(self, states: ArrayLike, times: ArrayLike) -> Flight:
        """Roll out balls, through every contact with table and net.

        Args:
            states: (B, 9) or (9,) states at time zero.
            times: (T,) or (B, T) s after that, not decreasing. At negative times the ball is in
                free flight.

        Returns:
            The flight, always with the batch dimension.

        Raises:
            ValueError: shapes that do not fit, numbers that are not finite, or times that fall.
        """
        from rallygap.models.ball import rollout

        first = _rows(states)
        moments = np.atleast_2d(np.asarray(times, dtype=np.float64))
        if first.ndim != 2 or first.shape[1] != STATE_SIZE:
            raise ValueError(f"states have shape {first.shape}, not (B, {STATE_SIZE})")
        if not (np.isfinite(first).all() and np.isfinite(moments).all()):
            raise ValueError("states and times must be finite")
        if moments.shape[0] not in (1, len(first)):
            raise ValueError(f"{moments.shape[0]} rows of times for {len(first)} balls")
        if (np.diff(moments, axis=1) < 0).any():
            raise ValueError("times must not fall")
        moments = np.ascontiguousarray(np.broadcast_to(moments, (len(first), moments.shape[1])))
        reached, count, time, surface, before, after = rollout.fly(first, moments, self.vector)
        return Flight(reached, Contacts(count, time, surface, before, after))

    def strike(self, states: ArrayLike, normals: ArrayLike, velocities: ArrayLike) -> Floats:
        """Return the (B, 9) states just after racket contacts.

        Args:
            states: (B, 9) just before the contact.
            normals: (B, 3) normals of the rackets, of any length, pointing to the ball.
            velocities: (B, 3) of the rackets at the contact point, m/s.

        Raises:
            ValueError: shapes that do not fit, or numbers that are not finite.
        """
        from rallygap.models.ball import rollout

        first, towards, moving = (_rows(part) for part in (states, normals, velocities))
        wanted = ((len(first), STATE_SIZE), (len(first), 3), (len(first), 3))
        if (first.shape, towards.shape, moving.shape) != wanted:
            raise ValueError("give states (B, 9), normals (B, 3) and velocities (B, 3)")
        towards = towards / np.linalg.norm(towards, axis=1, keepdims=True)
        if not all(np.isfinite(part).all() for part in (first, towards, moving)):
            raise ValueError("states, velocities and directions of normals must be finite")
        return rollout.strike(first, towards, moving, self.vector)


def _rows(values: ArrayLike) -> Floats:
    return np.ascontiguousarray(np.atleast_2d(values), dtype=np.float64)


def _checked(name: str, values: Any) -> dict[str, Any]:
    if name not in catalogue():
        hint = suggestion(name, catalogue())
        raise SimulatorError(f"there is no effect called {name!r}; {hint}")
    effect = catalogue()[name]
    values = {} if values is None else values
    if not isinstance(values, Mapping):
        raise SimulatorError(f"{name}: give its parameters by name, not {values!r}")
    known = [parameter.name for parameter in effect.parameters] + [NODES] * bool(effect.table)
    for unknown in [key for key in values if key not in known]:
        hint = suggestion(unknown, known)
        raise SimulatorError(f"{name} has no parameter {unknown!r}; {hint}")
    checked: dict[str, Any] = {
        parameter.name: _value(name, parameter, values) for parameter in effect.parameters
    }
    return {**checked, NODES: _rows_of_table(effect, values)} if effect.table else checked


def _rows_of_table(effect: Effect, values: Mapping[str, Any]) -> list[list[float]]:
    columns = ", ".join(effect.table)
    wanted = f"{effect.name}.{NODES}: give rows of {len(effect.table)} finite numbers: {columns}"
    try:
        rows = np.array(values.get(NODES, ()), dtype=np.float64).reshape(-1, len(effect.table))
    except (TypeError, ValueError, OverflowError):
        raise SimulatorError(wanted) from None
    if not np.isfinite(rows).all():
        raise SimulatorError(wanted)
    return rows.tolist()


def _value(effect: str, parameter: Parameter, values: Mapping[str, Any]) -> float:
    low, high = parameter.bounds
    allowed = f"a number from {low:g} to {high:g} ({parameter.unit})"
    if parameter.name not in values:
        if parameter.required:
            raise SimulatorError(f"{effect}.{parameter.name} is missing; give {allowed}")
        return parameter.neutral
    value = values[parameter.name]
    number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not number or not abs(value) <= sys.float_info.max or not low <= value <= high:
        raise SimulatorError(f"{effect}.{parameter.name} is {value!r}; give {allowed}")
    return float(value)
