"""Known errors planted on measured sets, and whether verdicts find them; 45 minutes.

Every set is cross-validated over its recordings: the base simulator of a fold is the nominal one as
amended by the verdict on the other folds. Errors are planted in it or in the fold's recordings.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.settings import DEFAULTS
from rallygap.pipeline.experiments.known_answers.answers import Diagnosis, references, verdicts
from rallygap.pipeline.experiments.known_answers.design import Question, plant, planted_errors
from rallygap.pipeline.experiments.known_answers.scores import Answer, answer_table, set_scores
from rallygap.pipeline.gap.folds import fold_numbers
from rallygap.pipeline.gap.measured_shots import read_shots
from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.paths import measured_sets
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage

SETS = ("tt3d", "spindoe", "isr_ball_prediction")
FOLDS = 2  # of the cross-validation over recordings
NOMINAL = "literature"  # simulator that the base simulators are amended from


def known_answers(run: StageRun) -> None:
    """Ask all questions about the measured sets; write their table and scores.

    Raises:
        InputError: a set cannot be read, or has too few recordings or shots.
    """
    folder, scratch = measured_sets(), run.scratch("verdicts")
    sets = [_read(folder, name, scratch / name) for name in SETS]
    answers = _ask(sets, FOLDS)
    scores = {}
    for measured in sets:
        own = [answer for answer in answers if answer.question.set == measured.name]
        scores[measured.name] = set_scores(own) | {"folds": FOLDS, "nominal": NOMINAL}
    run.publish({"answers": answer_table(answers)}, digits=6)
    write_json(run.report("scores.json"), scores)


@dataclass(frozen=True)
class _MeasuredSet:
    """A set with (B,) the fold of each shot, and a folder for verdicts."""

    name: str
    shots: Shots
    fold: NDArray[np.int64]
    folder: Path


@dataclass(frozen=True)
class _Fold:
    """The shots of a part of a set's recordings, and their base simulator."""

    unplanted: Question
    shots: Shots
    base: Simulator
    folder: Path

    def diagnosis(self, question: Question, references: Mapping[str, float]) -> Diagnosis:
        error, seed = question.error, question.seed
        simulator, shots = plant(error, self.base, self.shots, references, seed)
        return Diagnosis(self.folder / f"{question.name}.json", shots, simulator)

    def before_planting(self) -> Diagnosis:
        file = self.folder / f"{self.unplanted.fold}.references.json"
        return Diagnosis(file, self.shots, self.base)


def _read(folder: Path, name: str, scratch: Path) -> _MeasuredSet:
    shots = read_shots(folder / name, name).shots
    fold = fold_numbers(name, shots.groups, FOLDS)
    least = DEFAULTS.verify.held_out
    if np.bincount(fold, minlength=FOLDS).min() < least:
        raise InputError(name, f"has a fold of fewer than {least} shots; record more")
    return _MeasuredSet(name, shots, fold, scratch)


def _folds(sets: Sequence[_MeasuredSet], count: int) -> list[_Fold]:
    """Return all folds of all sets; their base simulators are found first."""
    nominal = load_simulator(NOMINAL)
    places = [(measured, number) for measured in sets for number in range(count)]
    others = [
        Diagnosis(measured.folder / f"{k}.base.json", measured.shots[measured.fold != k], nominal)
        for measured, k in places
    ]
    return [
        _Fold(
            Question(measured.name, k),
            measured.shots[measured.fold == k],
            amended(nominal, verdict),
            measured.folder,
        )
        for (measured, k), verdict in zip(places, verdicts(others, "base simulators"), strict=True)
    ]


def _ask(sets: Sequence[_MeasuredSet], count: int) -> list[Answer]:
    """Return the answers to all questions, in the order of sets and questions."""
    folds = _folds(sets, count)
    before = verdicts([fold.diagnosis(fold.unplanted, {}) for fold in folds], "unplanted folds")
    values = references([fold.before_planting() for fold in folds])
    unplanted = [(k, fold.unplanted) for k, fold in enumerate(folds)]
    asked = [
        (k, Question(question.set, question.fold, error))
        for k, question in unplanted
        for error in planted_errors(before[k].minimum_detectable)
    ]
    tasks = [folds[k].diagnosis(question, values[k]) for k, question in asked]
    every = zip([*unplanted, *asked], [*before, *verdicts(tasks, "questions")], strict=True)
    return [Answer(question, verdict, before[k], values[k]) for (k, question), verdict in every]


if __name__ == "__main__":
    run_stage(known_answers)
