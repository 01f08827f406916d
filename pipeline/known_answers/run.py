"""The run of ``rallygap known-answers``: measured sets in, a table and scores out."""

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.ball.simulator import Simulator
from models.gap.amend.simulator import amended
from models.gap.fit.shots import Shots
from models.gap.settings import DEFAULTS
from models.gap.verdict import Verdict
from pipeline.gap.measured_shots import read_shots
from pipeline.io.artifacts import write_csv, write_json
from pipeline.io.simulators import load_simulator
from pipeline.known_answers.answers import Diagnosis, fingerprint, verdicts
from pipeline.known_answers.design import Question, fold_numbers, questions
from pipeline.known_answers.scores import Answer, set_scores
from pipeline.known_answers.tables import answer_table
from pipeline.runtime.errors import InputError
from pipeline.runtime.git import git_commit
from pipeline.runtime.provenance import short

NOMINAL = "literature"  # simulator that the base simulators are amended from
REPORT = Path("reports") / "real"
TABLE, SCORES = "known_answers.csv", "known_answers.json"


@dataclass(frozen=True)
class MeasuredSet:
    """A measured set in folds.

    Attributes:
        name: of the set and of its adapter.
        shots: all of them.
        fold: (B,) number of the fold of each shot.
        folds: how many there are.
        fingerprint: of all that its verdicts depend on.
    """

    name: str
    shots: Shots
    fold: NDArray[np.int64]
    folds: int
    fingerprint: str


def run_known_answers(
    root: Path, folder: Path, names: Sequence[str], folds: int
) -> dict[str, dict[str, Any]]:
    """Ask all questions about measured sets; write their table and scores to ``reports/real``.

    A killed run resumes, as long as nothing that its verdicts depend on has changed.

    Args:
        root: of the repository.
        folder: with a folder for each set.
        names: of the sets, each that of the adapter that reads it.
        folds: of the cross-validation over recordings.

    Returns:
        The scores by set.

    Raises:
        InputError: a set cannot be read, or has too few recordings or shots.
    """
    scratch = root / "scratch" / "known_answers"
    sets = [_read(root, folder, name, folds) for name in dict.fromkeys(names)]
    answers = _ask(sets, scratch)
    scores = {one.name: _scores(root, one, answers) for one in sets}
    write_csv(root / REPORT / TABLE, answer_table(answers))
    write_json(root / REPORT / SCORES, scores)
    for one in sets:
        shutil.rmtree(scratch / one.name, ignore_errors=True)
    return scores


def _read(root: Path, folder: Path, name: str, folds: int) -> MeasuredSet:
    shots = read_shots(folder / name, name).shots
    fold = fold_numbers(name, shots, folds)
    least = DEFAULTS.verify.held_out
    if np.bincount(fold, minlength=folds).min() < least:
        raise InputError(name, f"has a fold of fewer than {least} shots; ask for fewer folds")
    return MeasuredSet(name, shots, fold, folds, fingerprint(root, shots, folds))


def _ask(sets: Sequence[MeasuredSet], scratch: Path) -> list[Answer]:
    """Return the answers to all questions, in the order of sets and questions."""
    bases = _base_simulators(sets, scratch)
    folds = [(one, Question(one.name, fold)) for one in sets for fold in range(one.folds)]
    unplanted = _verdicts(folds, bases, scratch, "unplanted folds")
    asked = [
        (one, question)
        for (one, fold), verdict in zip(folds, unplanted, strict=True)
        for question in questions(one.name, fold.fold, verdict.minimum_detectable)
    ]
    planted = _verdicts(asked, bases, scratch, "questions")
    of_fold = {fold: verdict for (_, fold), verdict in zip(folds, unplanted, strict=True)}
    return [
        Answer(
            question,
            verdict,
            of_fold[Question(question.set, question.fold)],
            bases[question.set, question.fold],
        )
        for (_, question), verdict in zip([*folds, *asked], [*unplanted, *planted], strict=True)
    ]


def _verdicts(
    asked: Sequence[tuple[MeasuredSet, Question]],
    bases: dict[tuple[str, int], Simulator],
    scratch: Path,
    description: str,
) -> list[Verdict]:
    """Return the verdicts on questions about sets."""
    diagnoses = [
        Diagnosis(
            file=_folder(scratch, one) / f"{question.name}.json",
            shots=one.shots[one.fold == question.fold],
            simulator=bases[one.name, question.fold],
            error=question.error,
            seed=question.seed,
        )
        for one, question in asked
    ]
    return verdicts(diagnoses, description)


def _base_simulators(
    sets: Sequence[MeasuredSet], scratch: Path
) -> dict[tuple[str, int], Simulator]:
    """Return the nominal simulator as amended by the other folds, for each set and fold."""
    nominal = load_simulator(NOMINAL)
    places = [(one, fold) for one in sets for fold in range(one.folds)]
    diagnoses = [
        Diagnosis(_folder(scratch, one) / f"{fold}.base.json", one.shots[one.fold != fold], nominal)
        for one, fold in places
    ]
    found = verdicts(diagnoses, "base simulators")
    return {
        (one.name, fold): amended(nominal, verdict)
        for (one, fold), verdict in zip(places, found, strict=True)
    }


def _folder(scratch: Path, one: MeasuredSet) -> Path:
    return scratch / one.name / short(one.fingerprint)


def _scores(root: Path, one: MeasuredSet, answers: Sequence[Answer]) -> dict[str, Any]:
    """Return the scores of one set, and where they come from."""
    own = [answer for answer in answers if answer.question.set == one.name]
    origin = {
        "folds": one.folds,
        "nominal": NOMINAL,
        "commit": git_commit(root),
        "fingerprint": one.fingerprint,
    }
    return set_scores(own) | origin
