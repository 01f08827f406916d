"""Two engines compared: their parameters, and how far their flights are apart."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from rallygap.models.audit.audit import Audit
from rallygap.models.audit.selection import Flown
from rallygap.models.ball.state import POSITION
from rallygap.models.engines.engine import Engine
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.pipeline.engines.audited import audited
from rallygap.pipeline.web.numbers import number, with_unit

MM = 1e3
SAME = 1e-3  # relative difference of values that are alike


@dataclass(frozen=True)
class Apart:
    """How far the balls of two engines are apart, medians over the probes.

    Attributes:
        flight_mm: after 0.4 s of flight.
        bounce_mm: 0.15 s after a bounce begins.
    """

    flight_mm: float
    bounce_mm: float

    @property
    def distances(self) -> dict[str, float]:
        """Both, with four significant digits."""
        shown = {"flight_mm": self.flight_mm, "bounce_mm": self.bounce_mm}
        return {name: float(number(value)) for name, value in shown.items()}


@dataclass(frozen=True)
class Comparison(Apart):
    """An engine compared with another one.

    Attributes:
        name: of the other.
        audit: of the other.
    """

    name: str
    audit: Audit

    @classmethod
    def of(cls, audit: Audit, other: Engine) -> "Comparison":
        """Audit the other engine, and fly the probes of an audit in it.

        Raises:
            InputError: the other engine fails.
        """
        found = audited(other)
        return cls(*distances(audit, other), other.name, found)

    def sentences(self, audit: Audit) -> list[str]:
        """Return what differs from the audit of the first engine."""
        table = self.table(audit)
        differing = ", ".join(
            f"{name} {here} and {there}" for name, here, there in zip(*table.values(), strict=True)
        )
        return [
            f"Compared with {self.name}, balls are {number(self.flight_mm)} mm apart after 0.4 s "
            f"of flight and {number(self.bounce_mm)} mm after a bounce, in the median.",
            f"Parameters that differ: {differing or 'none'}.",
        ]

    def table(self, audit: Audit) -> dict[str, list[str]]:
        """Return the columns of the parameters that differ."""
        here, there = (
            {one.hypothesis: one.value for one in each.effects} for each in (audit, self.audit)
        )
        names = [one for one in {**here, **there} if _differ(here.get(one), there.get(one))]
        return {
            "parameter": [one.identity for one in names],
            "audited ": [_shown(one, here.get(one)) for one in names],
            f"{self.name} ": [_shown(one, there.get(one)) for one in names],
        }

    def content(self) -> dict[str, Any]:
        """Return the part of ``audit.json``."""
        return {
            "engine": self.name,
            "effects": {
                one.hypothesis.identity: float(number(one.value)) for one in self.audit.effects
            },
            **self.distances,
        }


def distances(audit: Audit, other: Engine) -> tuple[float, float]:
    """Return how far balls of another engine are from those of an audit, in the order of ``Apart``.

    Only the other one flies: the audit has the flights of its engine.
    """
    return _distance(audit.flown["flight"], other), _distance(audit.flown["table"], other)


def _distance(flown: Flown, other: Engine) -> float:
    others = other.fly(flown.probes.states, flown.probes.times)
    away = np.linalg.norm((flown.states - others)[:, -1, POSITION], axis=-1)
    return float(MM * np.median(away))


def _differ(here: float | None, there: float | None) -> bool:
    if here is None or there is None:
        return True
    return abs(here - there) > SAME * max(abs(here), abs(there))


def _shown(parameter: Hypothesis, value: float | None) -> str:
    return "–" if value is None else with_unit(value, parameter.declaration.unit)
