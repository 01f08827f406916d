"""Detection limits: the minimum size of a cause that the data of a trial can show.

The shots are those of the trial without causes, with the same launches and frames. Linearised about
their true launches, with the true noise and bounce scatter of the trial, they give the information
about every parameter of the catalogue. Nothing is estimated and no method is asked, so a limit is a
property of the data. A cause is detectable at 5.8 standard errors.

Errors that all shots share are random effects: a distortion is a Gaussian field and the labels'
error of a session a Gaussian vector, both of their true size. In a basis of independent components
of unit variance they are linear, so they are columns next to the hypotheses, with a prior.
Integrating them out leaves the information on the hypotheses that these errors do not hide.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from experiments.exam.interface import Recording, shots_of
from experiments.exam.simulate.camera_errors import Distortion
from experiments.exam.simulate.recordings import simulate_trial
from experiments.exam.simulate.trial import Trial
from rallygap.models.ball.camera_field import covariance
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.gap.fit.linearize import Linearised, ballistic_nuisance, linearise
from rallygap.models.gap.fit.measurement import Schedule, count_bounces
from rallygap.models.gap.fit.noise import Noise, gram_matrices
from rallygap.models.gap.fit.projection import eliminate_nuisance, identifiable_directions
from rallygap.models.gap.fit.shared_errors import SharedErrors
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.hypotheses import LABEL_SIGNS, Hypothesis, hypotheses
from rallygap.models.gap.inference.score_test import Evidence
from rallygap.models.gap.settings import GapSettings

SETTINGS = GapSettings()
DETECTABLE = SETTINGS.inference.detectable  # standard errors
MINIMUM_FLIPPED = 4.0  # spin labels with the wrong sign, on average, in a detectable share of them
# Of what the workflow takes for random: label errors of a shot, scatter across.
MINIMUM_NOISE = 1e-3
MINIMUM_TIMING = 1e-4  # s, of time stamps that are exact
MINIMUM_OWN_INFORMATION = 1e-2  # of a parameter's information, with all other parameters free
FIELD_PLACES = 400  # that represent the recorded region
FIELD_LEFT_OUT = 1e-3  # of a distortion's variance


@dataclass(frozen=True)
class DetectionLimits:
    """What the shots of a trial can show."""

    evidence: Evidence  # on every parameter of the catalogue, about the nominal simulator
    labelled: int  # number of shots with spin labels
    withheld: tuple[str, ...]  # effects that are removed from the catalogue

    @classmethod
    def of(cls, trial: Trial) -> "DetectionLimits":
        """Return the limits of a trial; its causes do not matter."""
        clean = trial.without_causes
        recordings, truth = simulate_trial(clean)
        shots = shots_of([_with_distinct_labels(recording) for recording in recordings])
        states = truth.states(shots.times[:, :1])[:, 0]
        evidence = _evidence(clean, shots, states)
        return cls(evidence, int(shots.labelled.any(axis=1).sum()), trial.withheld)

    def minimum_sizes(self, hidden: tuple[Hypothesis, ...]) -> list[float]:
        """Return the minimum detectable size of each parameter.

        The other hidden and the simulator's own parameters are free. Where the shots cannot
        distinguish a parameter from these, as buoyancy from gravity, the most similar one is fixed.
        With a withheld effect, all parameters of the remaining catalogue are free. Infinite where
        no value within the parameter's bounds is detectable.
        """
        return [self._minimum_size(parameter, hidden) for parameter in hidden]

    def indistinguishable(
        self, hidden: Hypothesis, size: float, others: tuple[Hypothesis, ...] = ()
    ) -> tuple[str, ...]:
        """Return identities of parameters that explain a cause of a size as well as its own.

        With any of them free, less than the detection limit is left of the cause. Where no single
        parameter does this, pairs of the simulator's own are tried for an effect that it lacks.

        Args:
            hidden: the parameter of the cause.
            size: by which it differs from nominal.
            others: parameters that are hidden at the same time, and free.
        """
        if hidden == LABEL_SIGNS:
            return ()
        (k,), free = self._places([hidden]), self._places(others)
        observable = np.flatnonzero(self.evidence.observable).tolist()
        rivals = [j for j in observable if j not in (k, *free)]
        own = [] if self.evidence.listed[k] else [j for j in self.evidence.free if j in rivals]

        def substitutes(sets: Iterable[tuple[int, ...]]) -> tuple[str, ...]:
            informations = ((indices, self._information(k, [*indices, *free])) for indices in sets)
            hiding = (
                indices
                for indices, information in informations
                if abs(size) * float(np.sqrt(max(information, 0.0))) < DETECTABLE
            )
            members = dict.fromkeys(j for indices in hiding for j in indices)
            return tuple(self.evidence.columns[j].identity for j in members)

        return substitutes(combinations(rivals, 1)) or substitutes(combinations(own, 2))

    def _information(self, k: int, free: list[int]) -> float:
        return float(self.evidence.score_test([k], free).information[0, 0])

    def _minimum_size(self, hidden: Hypothesis, all_hidden: tuple[Hypothesis, ...]) -> float:
        if hidden == LABEL_SIGNS:
            possible = self.labelled > 0 and hidden.effect not in self.withheld
            return MINIMUM_FLIPPED / self.labelled if possible else np.inf
        (k,) = self._places([hidden])
        free = self._free(k, self._places([other for other in all_hidden if other != hidden]))
        if not self._decidable(k, free):
            return np.inf
        if hidden.effect not in self.withheld:
            return self.evidence.minimum_detectable_effect(k, free)
        total, columns = self.evidence.total, self.evidence.columns
        observable = np.flatnonzero(self.evidence.observable).tolist()
        known = [j for j in observable if columns[j].effect not in self.withheld]
        mixed = identifiable_directions(total[np.ix_(known, known)]).T @ total[known, k]
        own = total[k, k] - mixed @ mixed
        enough = own > MINIMUM_OWN_INFORMATION * total[k, k]
        return float(DETECTABLE / np.sqrt(own)) if enough else np.inf

    def _free(self, k: int, others: list[int]) -> list[int]:
        """Return the other and the simulator's own parameters, without one too similar to ``k``."""
        own = [j for j in self.evidence.free if j != k]
        free = sorted({*own, *others})
        if self._decidable(k, free) or not own:
            return free
        closest = max(own, key=lambda j: self._information(k, [i for i in free if i != j]))
        return [j for j in free if j != closest or j in others]

    def _decidable(self, k: int, free: list[int]) -> bool:
        evidence = self.evidence
        return bool(evidence.observable[k]) and evidence.decides(evidence.score_test([k], free))

    def _places(self, parameters: Sequence[Hypothesis]) -> list[int]:
        columns = self.evidence.columns
        return [columns.index(parameter) for parameter in parameters if parameter != LABEL_SIGNS]


def _evidence(trial: Trial, shots: Shots, states: Floats) -> Evidence:
    """Return the evidence of all shots in the true noise, about their true (B, 9) states."""
    bounces = count_bounces(trial.nominal, Schedule.of(shots), states)
    kicks = min(int(bounces.max(initial=0)), SETTINGS.fit.max_kicks)
    nuisance = ballistic_nuisance(states, kicks)
    linear = linearise(shots, trial.nominal, nuisance, hypotheses(trial.nominal))
    if trial.errors.distortion is not None:
        basis = _field_basis(shots.positions, linear.sampled, trial.errors.distortion)
        linear = linear.with_shared(replace(linear.shots, shared=basis))
    if trial.errors.labels.session:
        linear = _with_session_error(linear, trial.errors.labels.session)
    noise = _noise(trial)
    known = gram_matrices(linear, noise, linear.sampled.astype(float), np.ones(len(shots)))
    left = eliminate_nuisance(known.total(noise), linear.nuisance_count)
    scores, information = SharedErrors.of(left, len(linear.columns)).parts(left)
    of_prior = len(scores) - len(shots)
    return Evidence(linear.columns, linear.listed, scores, information, SETTINGS, of_prior)


def _field_basis(positions: Floats, sampled: Bools, distortion: Distortion) -> Floats:
    """Return (B, N, J) components of a field of one coordinate, zero where nothing is sampled.

    They are the leading ones of the Karhunen-Loeve expansion over recorded places (Nystroem).
    """
    points = positions[sampled]
    chosen = points[np.linspace(0, len(points) - 1, FIELD_PLACES).astype(np.int64)]
    values, vectors = np.linalg.eigh(covariance(chosen, chosen, distortion.length))
    tail = np.cumsum(np.maximum(values, 0.0))
    used = tail > FIELD_LEFT_OUT * tail[-1]
    basis = np.zeros((*sampled.shape, int(used.sum())))
    across = covariance(points, chosen, distortion.length)
    basis[sampled] = distortion.size * across @ (vectors[:, used] / np.sqrt(values[used]))
    return basis


def _with_session_error(linear: Linearised, size: float) -> Linearised:
    """Return linearised shots with columns of the labels' error of a session."""
    of_labels = np.zeros((*linear.labels.shape[:3], 3))
    of_labels[linear.labelled] = size * np.eye(3)
    of_positions = np.zeros((*linear.positions.shape[:3], 3))

    def joined(columns: Floats, more: Floats) -> Floats:
        return np.concatenate([columns[..., :-1], more, columns[..., -1:]], axis=-1)

    positions, labels = joined(linear.positions, of_positions), joined(linear.labels, of_labels)
    return replace(linear, positions=positions, labels=labels)


def _noise(trial: Trial) -> Noise:
    """Return the true noise of a trial in the workflow's terms."""
    cameras, table = trial.cameras, trial.nominal.effects["table_bounce"]
    slow = cameras.slow_error.share
    restitution = table["restitution"]
    impulse = table["friction"] * (1.0 + restitution)
    upwards, along = trial.scatter.restitution * restitution, trial.scatter.friction * impulse
    return Noise(
        white=cameras.position_noise * float(np.sqrt(1.0 - slow)),
        slow=cameras.position_noise * float(np.sqrt(slow)),
        slow_time=cameras.slow_error.time,
        label=max(cameras.spin_noise, MINIMUM_NOISE),
        label_arc=max(trial.errors.labels.arc, MINIMUM_NOISE),
        label_common=max(trial.errors.labels.shot, MINIMUM_NOISE),
        scatter=(max(upwards, MINIMUM_NOISE), max(along, MINIMUM_NOISE), MINIMUM_NOISE),
        timing=max(trial.errors.stamps.deviation, MINIMUM_TIMING),
    )


def _with_distinct_labels(recording: Recording) -> Recording:
    """Return a recording with one label for every run of equal ones, which are one measurement."""
    labels = recording.labels
    first = np.ones(len(labels), dtype=bool)
    first[1:] = (labels[1:] != labels[:-1]).any(axis=1)
    return replace(recording, label_times=recording.label_times[first], labels=labels[first])
