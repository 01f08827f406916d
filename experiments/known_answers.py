"""Known answers on measured sets: errors that are planted, and whether verdicts find them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal
from zlib import crc32

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from experiments.resumed import Diagnosis, json_results
from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.fit.shots import Shots, held_out
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.name.distortion import CAMERA
from rallygap.models.gap.name.naming import Named, name, with_estimates
from rallygap.models.gap.settings import DEFAULTS
from rallygap.models.gap.settings import Question as Naming
from rallygap.models.gap.verdict import Cause, Verdict
from rallygap.pipeline.io.metrics import rounded
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.web.numbers import interval_text, number

Place = Literal["simulator", "recordings"]

DISTORTION = "camera_distortion"  # of positions, a random field
LENGTH = 0.8  # m, over which the distortion changes
WAVES = 64  # that the distortion is a sum of
# Sizes of errors in minimum detectable effects of the diagnosed shots, and of distortions in m.
SIZES = {"2x": 2.0, "4x": 4.0, "8x": 8.0}
DISTORTION_SIZES = {"2 mm": 0.002, "4 mm": 0.004, "8 mm": 0.008}

# Parameters of planted errors, each with the largest error that is still plausible, in its unit.
IN_SIMULATOR = {
    "drag.cd": 0.4,
    "magnus.cm": 0.5,
    "gravity.g": 4.0,
    "table_bounce.restitution": 0.25,
    "table_bounce.friction": 0.25,
    "wind.x": 5.0,
    "wind.y": 5.0,
    "frame_tilt.x": 0.15,
}
# How recordings are changed: by the parameter that describes it.
IN_RECORDINGS = {
    "position_scale.s": 0.1,
    "frame_tilt.y": 0.1,
    "clock_rate.d": 0.15,
    "spin_axis_bias.x": 0.6,
    "spin_gain.s": 0.45,
}
IDENTITIES = (*IN_SIMULATOR, *IN_RECORDINGS, "table_tilt.y")  # that have reference values
COLUMNS = [
    *("set", "fold", "place", "planted", "size", "value"),
    *("true", "verdict", "causes", "leading", "by_name", "exact", "covered", "false"),
    *("before_mm", "after_mm", "floor_mm"),
]


@dataclass(frozen=True)
class PlantedError:
    """One error that is planted.

    Attributes:
        place: where.
        identity: of the parameter that describes it, or ``DISTORTION``.
        size: its name among ``SIZES`` or ``DISTORTION_SIZES``.
        value: how large it is, in the parameter's unit; distortion in m.
    """

    place: Place
    identity: str
    size: str
    value: float


@dataclass(frozen=True)
class Question:
    """One diagnosis whose answer is known.

    Attributes:
        set: the measured set.
        fold: which part of its recordings is diagnosed, from 0.
        error: that is planted; None in the unplanted question.
    """

    set: str
    fold: int
    error: PlantedError | None = None

    @property
    def name(self) -> str:
        """Stem of a file's name, which no other question of its set has."""
        error = self.error
        parts = (error.place, error.identity, error.size) if error else ("unplanted",)
        return ".".join([str(self.fold), *parts])

    @property
    def seed(self) -> int:
        """Of what is random in the error: the same for all errors of a fold."""
        return crc32(f"{self.set}/{self.fold}".encode())


def planted_errors(limits: Mapping[str, float]) -> Iterator[PlantedError]:
    """Yield the errors that shots could show, none of them implausibly large.

    Args:
        limits: minimum detectable effects of the shots, by identity.
    """
    places: dict[Place, dict[str, float]] = {"simulator": IN_SIMULATOR, "recordings": IN_RECORDINGS}
    for place, largest in places.items():
        for identity, most in largest.items():
            for size, times in SIZES.items():
                value = times * limits.get(identity, np.inf)
                if value <= most:
                    yield PlantedError(place, identity, size, value)
    for size, value in DISTORTION_SIZES.items():
        yield PlantedError("recordings", DISTORTION, size, value)


def plant(
    error: PlantedError | None,
    simulator: Simulator,
    shots: Shots,
    references: Mapping[str, float],
    seed: int,
) -> tuple[Simulator, Shots]:
    """Return the simulator and the shots of a question.

    Args:
        error: None changes nothing.
        simulator: without the error.
        shots: without the error.
        references: values in the unchanged recordings, by identity. An error in the simulator is
            added to them, or subtracted where the parameter's range ends.
        seed: of the distortion.
    """
    if error is None:
        return simulator, shots
    if error.identity == DISTORTION:
        return simulator, _distorted(shots, error.value, seed)
    if error.place == "recordings":
        return simulator, _changed(shots, error.identity, error.value)
    hypothesis, value = Hypothesis.from_identity(error.identity), references[error.identity]
    fits = value + error.value <= hypothesis.declaration.bounds[1]
    return hypothesis.at(simulator, value + error.value if fits else value - error.value), shots


def true_values(error: PlantedError, references: Mapping[str, float]) -> dict[str, float]:
    """Return the values by identity that a correct verdict finds; none for a distortion.

    Args:
        error: that is planted.
        references: values in the unchanged recordings, by identity.
    """
    identity, value = error.identity, error.value
    if identity == DISTORTION:
        return {}
    if error.place == "simulator":
        return {identity: references[identity]}
    if identity == "frame_tilt.y":
        # The table turns with the frame; its normal is tilted the other way.
        signs = {"frame_tilt.y": 1, "table_tilt.y": -1}
        return {name: references[name] + sign * value for name, sign in signs.items()}
    if identity == "spin_axis_bias.x":
        return {identity: references[identity] + value}
    return {identity: (1 + references[identity]) * (1 + value) - 1}


def _distorted(shots: Shots, size: float, seed: int) -> Shots:
    """Shift positions by a smooth random field with this standard deviation of a coordinate, m."""
    random = np.random.default_rng(seed)
    waves = random.normal(0.0, 1 / LENGTH, (3, WAVES))
    phases = random.uniform(0.0, 2 * np.pi, WAVES)
    amplitudes = random.normal(0.0, size * np.sqrt(2 / WAVES), (WAVES, 3))
    field = np.cos(shots.positions @ waves + phases) @ amplitudes
    return replace(shots, positions=shots.positions + field)


def _changed(shots: Shots, identity: str, value: float) -> Shots:
    """Return recordings with the error that a parameter describes."""
    more = 1 + value
    match identity:
        case "position_scale.s":
            return replace(shots, positions=more * shots.positions)
        case "clock_rate.d":
            return replace(shots, times=more * shots.times, label_times=more * shots.label_times)
        case "spin_gain.s":
            return replace(shots, labels=more * shots.labels)
    turn = Rotation.from_rotvec([value, 0.0, 0.0]).as_matrix().T  # about x
    turned = replace(shots, labels=shots.labels @ turn)
    if identity == "spin_axis_bias.x":
        return turned
    return replace(turned, positions=shots.positions @ turn)  # gravity leans towards +y


def references(folds: Sequence[Diagnosis]) -> list[dict[str, float]]:
    """Return the reference values of unplanted folds by identity; those on file are kept.

    Reference values are what the recordings of a fold say about parameters before anything is
    planted. They are the true values of planted errors. The base simulator's values are those of
    other recordings, which may differ: an error planted about them would have another size than it
    says.

    Args:
        folds: with files for the values.

    Raises:
        InputError: a file that an earlier run left is broken.
    """
    tasks = {fold.file: partial(reference_values, fold.shots, fold.simulator) for fold in folds}
    values = json_results(tasks, "reference values")
    for fold, content in zip(folds, values, strict=True):
        if not isinstance(content, dict) or content.keys() != set(IDENTITIES):
            raise InputError(fold.file, "has no reference values; remove it and run again")
    return values


def reference_values(shots: Shots, simulator: Simulator) -> dict[str, float]:
    """Return maximum-likelihood values by identity, each with all causes distinguishable from it.

    A parameter that the shots do not show keeps the simulator's value.
    """
    named = name(shots[~held_out(shots, DEFAULTS)], Naming(simulator, DEFAULTS, ()))
    return {identity: _estimate(named, identity) for identity in IDENTITIES}


def _estimate(named: Named, identity: str) -> float:
    hypothesis, explainer = Hypothesis.from_identity(identity), named.explainer
    causes, columns = named.explanation.causes, explainer.evidence.columns
    k = columns.index(hypothesis) if hypothesis in columns else None
    if k is None or not explainer.evidence.observable[k]:
        return hypothesis.value(explainer.nominal)
    # A cause that stands in for the parameter would leave it undetermined.
    others = (j for j in causes if k not in explainer.alternatives(j, causes))
    return hypothesis.value(with_estimates(explainer, tuple(sorted({k, *others}))))


@dataclass(frozen=True)
class Answer:
    """The verdict on a question, and its score.

    Attributes:
        question: that was asked.
        verdict: on it.
        truth: values by identity that a correct verdict finds besides those of the unplanted one.
        leading: whether the first new cause is what was planted, or not separable from it.
        by_name: whether it is what was planted, not only one of its class.
        exact: whether the planted error is leading, and there is no other new cause.
        false: leading causes among the new ones that are not what was planted.
        covered: whether intervals of planted parameters contain the true values; one each that is
            new.
    """

    question: Question
    verdict: Verdict
    truth: dict[str, float]
    leading: bool
    by_name: bool
    exact: bool
    false: tuple[Cause, ...]
    covered: tuple[bool, ...]

    @classmethod
    def of(
        cls,
        question: Question,
        verdict: Verdict,
        unplanted: Verdict,
        references: Mapping[str, float],
    ) -> "Answer":
        """Return the score of a verdict.

        Args:
            question: that was asked.
            verdict: on it.
            unplanted: verdict on the unplanted question of the same fold.
            references: the fold's own values of parameters, by identity.
        """
        truth = true_values(question.error, references) if question.error else {}
        quantities = {*map(_quantity, truth)}
        new = _new_causes(verdict, unplanted)
        right = [not quantities.isdisjoint(map(_quantity, cause.possible)) for cause in new]
        return cls(
            question,
            verdict,
            truth,
            leading=any(right[:1]),
            by_name=any(_quantity(cause.identity) in quantities for cause in new[:1]),
            exact=any(right) and all(right),
            false=tuple(
                cause
                for cause, is_right in zip(new, right, strict=True)
                if cause.role == "leading" and not is_right
            ),
            covered=tuple(
                cause.interval[0] <= truth[cause.identity] <= cause.interval[1]
                for cause in new
                if cause.identity in truth
            ),
        )


def _new_causes(verdict: Verdict, unplanted: Verdict) -> list[Cause]:
    """Return the main causes that the planting added: the unplanted verdict does not have them.

    Camera distortion is none of them: all real recordings have one, and how much of it is found
    depends on what else is.
    """
    before = {cause.identity: cause for cause in unplanted.main_causes}
    return [
        cause
        for cause in verdict.main_causes
        if cause.identity != CAMERA.identity
        and not _same_departure(cause, before.get(cause.identity))
    ]


def set_scores(answers: Sequence[Answer]) -> dict[str, Any]:
    """Return the counts of one set's answers, and the coverage of intervals as a share.

    Questions with a distortion are counted apart: a correct verdict on one has no new leading
    cause.
    """
    errors = [answer.question.error for answer in answers]
    pairs = list(zip(answers, errors, strict=True))
    planted = [answer for answer, error in pairs if error and error.identity != DISTORTION]
    distorted = [answer for answer, error in pairs if error and error.identity == DISTORTION]
    unplanted = [answer.verdict for answer, error in pairs if error is None]
    covered = [inside for answer in planted for inside in answer.covered]
    return {
        "questions": len(planted),
        "leading": sum(answer.leading for answer in planted),
        "by_name": sum(answer.by_name for answer in planted),
        "exact": sum(answer.exact for answer in planted),
        "false_causes": sum(len(answer.false) for answer in planted),
        "intervals": len(covered),
        "covered": sum(covered),
        "coverage": rounded(sum(covered) / len(covered)) if covered else None,
        "distorted": len(distorted),
        "distorted_clean": sum(not answer.false for answer in distorted),
        "unplanted": len(unplanted),
        "unplanted_clean": sum(not verdict.leading for verdict in unplanted),
    }


def answer_table(answers: Sequence[Answer]) -> pd.DataFrame:
    """Return one row a question.

    ``value`` is what was planted, in the parameter's unit or m, ``true`` what a correct verdict
    finds, ``causes`` the main causes, each with the parameters that the shots cannot separate from
    it. Scores are empty where a question has none. Errors are means over the horizons.
    """
    return pd.DataFrame([_row(answer) for answer in answers], columns=COLUMNS)


def _row(answer: Answer) -> dict[str, Any]:
    question, verdict, error = answer.question, answer.verdict, answer.question.error
    row: dict[str, Any] = {
        "set": question.set,
        "fold": question.fold,
        "planted": "none",
        "verdict": verdict.verdict,
        "causes": "; ".join(map(_cause_text, verdict.main_causes)),
    }
    if error is not None:
        truth = (f"{identity} {number(value)}" for identity, value in answer.truth.items())
        row |= {
            "place": error.place,
            "planted": error.identity,
            "size": error.size,
            "value": error.value,
            "true": "; ".join(truth),
            "false": "; ".join(cause.identity for cause in answer.false),
        }
        if error.identity != DISTORTION:
            row |= {
                "leading": answer.leading,
                "by_name": answer.by_name,
                "exact": answer.exact,
                "covered": all(answer.covered) if answer.covered else None,
            }
    if verdict.gap:
        for name in ("before_mm", "after_mm", "floor_mm"):
            row[name] = float(np.mean(getattr(verdict.gap, name)))
    return row


def _cause_text(cause: Cause) -> str:
    estimate = f"{cause.identity} {number(cause.estimate)} ({interval_text(cause.interval)})"
    return " or ".join([estimate, *cause.alternatives])


def _same_departure(first: Cause, other: Cause | None) -> bool:
    """Whether two estimates depart as much from the nominal values: their intervals overlap."""
    if other is None:
        return False
    (low, high), (other_low, other_high) = (
        (cause.interval[0] - cause.nominal, cause.interval[1] - cause.nominal)
        for cause in (first, other)
    )
    return low <= other_high and other_low <= high


def _quantity(identity: str) -> str:
    return Hypothesis.from_identity(identity).quantity
