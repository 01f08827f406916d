"""Omnibus terms, which no effect of the catalogue stands for, and their columns of the shots."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, SPIN, STATE_SIZE
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.linearize import Linearised, label_scales
from rallygap.models.gap.fit.measurement import Schedule
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.locate.propagation import Arc, arcs

TYPICAL_SPEED = 8.0  # m/s, so that numbers in a formula are of similar size
TYPICAL_FALL = 3.0  # m/s


@dataclass(frozen=True)
class Term(Hypothesis):
    """One term of the basis: ``effect`` is the phase, ``parameter`` its formula."""

    def listed(self, simulator: Simulator) -> bool:
        """No simulator lists a term."""
        return False

    def value(self, simulator: Simulator) -> float:
        """Every simulator has the value zero."""
        return 0.0


@dataclass(frozen=True)
class Terms:
    """Terms and their columns of B shots, like those of the hypotheses (linearize.py).

    Attributes:
        terms: the D terms.
        positions: (B, N, 3, D).
        labels: (B, L, 3, D), in units of the fitted spin.
    """

    terms: tuple[Term, ...]
    positions: Floats
    labels: Floats

    @classmethod
    def together(cls, parts: Sequence["Terms"]) -> "Terms":
        """Return several sets of terms as one."""
        return cls(
            tuple(term for part in parts for term in part.terms),
            np.concatenate([part.positions for part in parts], axis=3),
            np.concatenate([part.labels for part in parts], axis=3),
        )

    def where_used(self, linear: Linearised) -> "Terms":
        """Return the terms, zero where a measurement is not used."""
        positions = np.where(linear.sampled[..., None, None], self.positions, 0.0)
        labels = np.where(linear.labelled[..., None, None], self.labels, 0.0)
        return Terms(self.terms, positions, labels)


@dataclass(frozen=True)
class Flown:
    """Fitted flights of B shots.

    Attributes:
        linear: the shots.
        schedule: when they are measured.
        arcs: between bounces.
        states: (B, T, 9) at the times of the schedule; zero where an arc begins or ends.
    """

    linear: Linearised
    schedule: Schedule
    arcs: list[Arc]
    states: Floats

    @classmethod
    def of(cls, linear: Linearised) -> "Flown":
        """Return the flights of linearised shots."""
        schedule = Schedule.of(linear.shots)
        found = arcs(linear.simulator, linear.nuisance, schedule.times)
        states = np.zeros((*schedule.times.shape, STATE_SIZE))
        for arc in found:
            states[arc.rows] = np.where(arc.inside[..., None], arc.states, states[arc.rows])
        return cls(linear, schedule, found, states)

    @cached_property
    def sampled(self) -> Floats:
        """(B, N, 9) states at the samples."""
        return self.schedule.at_samples(self.states)

    @cached_property
    def spins(self) -> Floats:
        """(B, L, 3) rad/s at the labels."""
        return self.schedule.at_labels(self.states[..., SPIN])

    @cached_property
    def label_scales(self) -> Floats:
        """(B, L) rad/s, those of the labels."""
        return label_scales(self.spins)

    def measured_changes(self, terms: Sequence[Term], changes: Floats) -> Terms:
        """Return what sensors see of (B, T, 9, D) changes of the states."""
        places = self.schedule.at_samples(changes[:, :, POSITION])
        spins = self.schedule.at_labels(changes[:, :, SPIN])
        return Terms(tuple(terms), places, spins / self.label_scales[..., None, None])
