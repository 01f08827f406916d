"""Sizes: what the shots of a trial could show at best, and what looks alike on them.

The shots are those of the trial in a hall without causes, launches and frames the same. Linearised
about their true launches, in the noise and scatter of the trial as they are, they give the
information about every parameter of the catalogue. Nothing is estimated and no method is asked, so
that a size says what data can show and not what somebody makes of them. All shots count.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from models.ball.types import Floats
from models.exam.answer import shots_of
from models.exam.design.questions import Name
from models.exam.design.trial import Trial
from models.exam.names import name_of
from models.exam.simulate.recordings import held
from models.gap.fit.linearize import ballistic_nuisance, linearise
from models.gap.fit.measurement import Schedule, count_bounces
from models.gap.fit.noise import Noise, gram_matrices
from models.gap.fit.projection import eliminate_nuisance, identifiable_directions
from models.gap.fit.shots import Shots
from models.gap.hypotheses import Hypothesis, hypotheses
from models.gap.inference.score_test import Evidence
from models.gap.settings import GapSettings

SETTINGS = GapSettings()
SIGNS: Name = ("spin_sign_flip", "share")
FLIPPED = 4.0  # labels that read backwards, on average, of which enough are seen to be
LEAST = 1e-3  # of what the workflow takes for random: label errors of a shot, scatter across
OWN_PART = 1e-2  # of a parameter's information that must be left beside all others


@dataclass(frozen=True)
class Sight:
    """What the shots of a trial can show.

    Attributes:
        evidence: on every parameter of the catalogue, about the nominal simulator.
        labelled: shots with spin labels.
        withheld: effects that are not in question, so that nothing is taken for them.
    """

    evidence: Evidence
    labelled: int
    withheld: tuple[str, ...]

    @classmethod
    def of(cls, trial: Trial) -> "Sight":
        """Return the sight of a trial; its causes do not matter."""
        recordings, truth = held(replace(trial, causes={}, world="catalogue"))
        shots = shots_of(recordings)
        states = truth.states(shots.times[:, :1])[:, 0]
        evidence = _evidence(trial, shots, states)
        return cls(evidence, int(shots.labelled.any(axis=1).sum()), trial.withheld)

    def detectable(self, names: tuple[Name, ...]) -> list[float]:
        """Return the least sizes of parameters, each with the others and the nominal ones free.

        A parameter that no shots tell from the nominal ones, such as buoyancy from gravity, has its
        size beside all of these but the one most like it: it can be seen, though not be told apart.
        That of a withheld effect is what is left of it beside all that is not withheld. Infinite
        where the shots do not show a parameter at any value that makes sense.
        """
        return [self._detectable(one, [o for o in names if o != one]) for one in names]

    def alike(self, name: Name, size: float, others: tuple[Name, ...] = ()) -> tuple[str, ...]:
        """Return the names of what may stand in for a parameter that is off by a size.

        In place of it, any of them leaves less of it than could be detected. Where none does, two
        of the nominal simulator's own numbers may, together, for an effect that it lacks.

        Args:
            name: of the parameter.
            size: by which it is off.
            others: that are off at the same time, and free.
        """
        if name == SIGNS:
            return ()
        k, beside = self._place(name), self._places(others)
        seen = [
            j for j in np.flatnonzero(self.evidence.observable).tolist() if j not in (k, *beside)
        ]
        own = [] if self.evidence.listed[k] else [j for j in self.evidence.free if j in seen]

        def stand_ins(sets: Iterable[tuple[int, ...]]) -> tuple[str, ...]:
            enough = (
                one
                for one in sets
                if self._left(k, size, [*one, *beside]) < SETTINGS.inference.detectable
            )
            names = (name_of(self.evidence.columns[j]) for one in enough for j in one)
            return tuple(dict.fromkeys(names))

        return stand_ins(combinations(seen, 1)) or stand_ins(combinations(own, 2))

    def _left(self, k: int, size: float, beside: list[int]) -> float:
        """Return how many standard errors of a size are left beside what is free."""
        return abs(size) * float(np.sqrt(max(self._information(k, beside), 0.0)))

    def _information(self, k: int, beside: list[int]) -> float:
        return float(self.evidence.score_test([k], beside).information[0, 0])

    def _detectable(self, name: Name, others: list[Name]) -> float:
        if name == SIGNS:
            blind = self.labelled == 0 or name[0] in self.withheld
            return np.inf if blind else FLIPPED / self.labelled
        k = self._place(name)
        beside = self._beside(k, self._places(others))
        if not self._decides(k, beside):
            return np.inf
        if name[0] in self.withheld:
            return self._beside_all(k)
        return self.evidence.minimum_detectable_effect(k, beside)

    def _beside(self, k: int, others: list[int]) -> list[int]:
        """Return what is free beside a parameter: others and the nominal ones, if they can be."""
        own = [j for j in self.evidence.free if j != k]
        beside = sorted({*own, *others})
        if self._decides(k, beside) or not own:
            return beside
        closest = max(own, key=lambda j: self._information(k, [i for i in beside if i != j]))
        return [j for j in beside if j != closest or j in others]

    def _decides(self, k: int, beside: list[int]) -> bool:
        evidence = self.evidence
        return bool(evidence.observable[k]) and evidence.decides(evidence.score_test([k], beside))

    def _beside_all(self, k: int) -> float:
        """Return the least size of a parameter beside all effects that are not withheld."""
        total = self.evidence.total
        beside = self._in_question
        mixed = identifiable_directions(total[np.ix_(beside, beside)]).T @ total[beside, k]
        left = total[k, k] - mixed @ mixed
        return (
            float(SETTINGS.inference.detectable / np.sqrt(left))
            if left > OWN_PART * total[k, k]
            else np.inf
        )

    @cached_property
    def _in_question(self) -> list[int]:
        seen = np.flatnonzero(self.evidence.observable).tolist()
        return [k for k in seen if self.evidence.columns[k].effect not in self.withheld]

    def _place(self, name: Name) -> int:
        return self.evidence.columns.index(Hypothesis(*name))

    def _places(self, names: Sequence[Name]) -> list[int]:
        return [self._place(one) for one in names if one != SIGNS]


def _evidence(trial: Trial, shots: Shots, states: Floats) -> Evidence:
    kicks = min(
        int(count_bounces(trial.nominal, Schedule.of(shots), states).max(initial=0)),
        SETTINGS.fit.max_kicks,
    )
    unknowns = ballistic_nuisance(states, kicks)
    linear = linearise(shots, trial.nominal, unknowns, hypotheses(trial.nominal))
    noise = _noise(trial)
    known = gram_matrices(linear, noise, linear.sampled.astype(float), np.ones(len(shots)))
    left = eliminate_nuisance(known.total(noise), linear.nuisance_count)
    return Evidence(linear.columns, linear.listed, left.scores, left.information, SETTINGS)


def _noise(trial: Trial) -> Noise:
    """Return the noise of a trial in the workflow's terms."""
    cameras, table = trial.cameras, trial.nominal.effects["table_bounce"]
    slow = cameras.slow_error.share
    rebound = table["restitution"]
    impulse = table["friction"] * (1.0 + rebound)
    upwards, along = trial.scatter.restitution * rebound, trial.scatter.friction * impulse
    return Noise(
        white=cameras.position_noise * float(np.sqrt(1.0 - slow)),
        slow=cameras.position_noise * float(np.sqrt(slow)),
        slow_time=cameras.slow_error.time,
        label=max(cameras.spin_noise, LEAST),
        label_common=LEAST,
        scatter=(max(upwards, LEAST), max(along, LEAST), LEAST),
    )
