"""The run of ``rallygap known-answers``: measured sets in, a table and scores out."""

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rallygap.models.gap.settings import DEFAULTS
from rallygap.pipeline.gap.folds import fold_numbers
from rallygap.pipeline.gap.measured_shots import read_shots
from rallygap.pipeline.io.artifacts import write_csv, write_json
from rallygap.pipeline.known_answers.answers import fingerprint, verdicts
from rallygap.pipeline.known_answers.design import questions
from rallygap.pipeline.known_answers.folds import NOMINAL, MeasuredSet, folds_of
from rallygap.pipeline.known_answers.references import references
from rallygap.pipeline.known_answers.scores import Answer, set_scores
from rallygap.pipeline.known_answers.tables import answer_table
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.git import git_commit
from rallygap.pipeline.runtime.provenance import short

REPORT = Path("reports") / "real"
TABLE, SCORES = "known_answers.csv", "known_answers.json"


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
    commit = git_commit(root)
    sets = [_read(root, folder, name, folds) for name in dict.fromkeys(names)]
    answers = _ask(sets)
    scores = {one.name: _scores(one, answers, commit) for one in sets}
    write_csv(root / REPORT / TABLE, answer_table(answers))
    write_json(root / REPORT / SCORES, scores)
    for one in sets:
        shutil.rmtree(one.folder, ignore_errors=True)
    return scores


def _read(root: Path, folder: Path, name: str, folds: int) -> MeasuredSet:
    shots = read_shots(folder / name, name).shots
    fold = fold_numbers(name, shots.groups, folds)
    least = DEFAULTS.verify.held_out
    if np.bincount(fold, minlength=folds).min() < least:
        raise InputError(name, f"has a fold of fewer than {least} shots; ask for fewer folds")
    origin = fingerprint(root, shots, folds)
    scratch = root / "scratch" / "known_answers" / name / short(origin)
    return MeasuredSet(name, shots, fold, folds, origin, scratch)


def _ask(sets: Sequence[MeasuredSet]) -> list[Answer]:
    """Return the answers to all questions, in the order of sets and questions."""
    folds = folds_of(sets)
    before = verdicts([fold.diagnosis(fold.unplanted, {}) for fold in folds], "unplanted folds")
    values = references([fold.before_planting() for fold in folds])
    asked = [
        (k, question)
        for k, (fold, verdict) in enumerate(zip(folds, before, strict=True))
        for question in questions(fold.set, fold.number, verdict.minimum_detectable)
    ]
    tasks = [folds[k].diagnosis(question, values[k]) for k, question in asked]
    unplanted = [(k, fold.unplanted) for k, fold in enumerate(folds)]
    every = zip([*unplanted, *asked], [*before, *verdicts(tasks, "questions")], strict=True)
    return [Answer(question, verdict, before[k], values[k]) for (k, question), verdict in every]


def _scores(one: MeasuredSet, answers: Sequence[Answer], commit: str | None) -> dict[str, Any]:
    """Return the scores of one set, and where they come from."""
    own = [answer for answer in answers if answer.question.set == one.name]
    origin = {
        "folds": one.folds,
        "nominal": NOMINAL,
        "commit": commit,
        "fingerprint": one.fingerprint,
    }
    return set_scores(own) | origin
