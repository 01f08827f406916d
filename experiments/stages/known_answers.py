"""Known errors planted on measured sets, and whether verdicts find them; 45 minutes.

Every set is cross-validated over its recordings: the base simulator of a fold is the nominal one as
amended by the verdict on the other folds. Errors are planted in it or in the fold's recordings.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.folds import fold_numbers
from experiments.known_answers import (
    Answer,
    Question,
    answer_table,
    plant,
    planted_errors,
    references,
    set_scores,
)
from experiments.resumed import Diagnosis, verdicts
from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.settings import DEFAULTS
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
    answers = _ask(_folds(measured_sets(), run.scratch("verdicts")))
    scores = {}
    for name in SETS:
        own = [answer for answer in answers if answer.question.set == name]
        scores[name] = set_scores(own) | {"folds": FOLDS, "nominal": NOMINAL}
    run.publish({"answers": answer_table(answers)}, digits=6)
    write_json(run.report("scores.json"), scores)


@dataclass(frozen=True)
class _Fold:
    """The shots of a part of a set's recordings, their base simulator, and a folder for files."""

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


def _folds(folder: Path, scratch: Path) -> list[_Fold]:
    """Return all folds of all sets; their base simulators are found first."""
    nominal, least = load_simulator(NOMINAL), DEFAULTS.verify.held_out
    parts, others = [], []
    for name in SETS:
        shots = read_shots(folder / name, name).shots
        fold = fold_numbers(name, shots.groups, FOLDS)
        if np.bincount(fold, minlength=FOLDS).min() < least:
            raise InputError(name, f"has a fold of fewer than {least} shots; record more")
        for k in range(FOLDS):
            parts.append((Question(name, k), shots[fold == k]))
            others.append(Diagnosis(scratch / name / f"{k}.base.json", shots[fold != k], nominal))
    return [
        _Fold(question, shots, amended(nominal, verdict), scratch / question.set)
        for (question, shots), verdict in zip(
            parts, verdicts(others, "base simulators"), strict=True
        )
    ]


def _ask(folds: list[_Fold]) -> list[Answer]:
    """Return the answers to all questions, in the order of sets and questions."""
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
    return [Answer.of(question, verdict, before[k], values[k]) for (k, question), verdict in every]


if __name__ == "__main__":
    run_stage(known_answers)
