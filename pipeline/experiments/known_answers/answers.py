"""Verdicts and reference values in parallel, each a file, so that a killed run resumes."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.diagnose import diagnose
from rallygap.models.gap.fit.shots import Shots, held_out
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.name.naming import Named, name, with_estimates
from rallygap.models.gap.settings import DEFAULTS, Question
from rallygap.models.gap.verdict import Verdict, VerdictError
from rallygap.pipeline.experiments.known_answers.design import IN_RECORDINGS, IN_SIMULATOR
from rallygap.pipeline.io.artifacts import read_json, write_json, write_text
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.parallel import make_missing

IDENTITIES = (*IN_SIMULATOR, *IN_RECORDINGS, "table_tilt.y")  # that have reference values


@dataclass(frozen=True)
class Diagnosis:
    """Shots and a simulator to compare, and where the verdict is kept.

    Attributes:
        file: of the verdict.
        shots: to diagnose.
        simulator: the nominal one.
    """

    file: Path
    shots: Shots
    simulator: Simulator


def verdicts(diagnoses: Sequence[Diagnosis], description: str) -> list[Verdict]:
    """Return the verdicts on all diagnoses; those whose file is there are not made again.

    Args:
        diagnoses: in folders of a run of a stage.
        description: of the progress bar.

    Raises:
        InputError: a file that an earlier run left is broken.
    """
    make_missing({task.file: partial(_diagnose, task) for task in diagnoses}, description)
    return [_read_verdict(task.file) for task in diagnoses]


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
    make_missing(
        {fold.file: partial(_write_references, fold) for fold in folds}, "reference values"
    )
    return [_read_references(fold.file) for fold in folds]


def reference_values(shots: Shots, simulator: Simulator) -> dict[str, float]:
    """Return maximum-likelihood values by identity, each with all causes distinguishable from it.

    A parameter that the shots do not show keeps the simulator's value.
    """
    named = name(shots[~held_out(shots, DEFAULTS)], Question(simulator, DEFAULTS, ()))
    return {identity: _estimate(named, identity) for identity in IDENTITIES}


def _diagnose(task: Diagnosis) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numerical warnings would hide the progress
        verdict = diagnose(task.shots, task.simulator)
    write_text(task.file, verdict.to_json())


def _read_verdict(file: Path) -> Verdict:
    try:
        return Verdict.load(file)
    except VerdictError:
        raise InputError(file, "is no verdict; remove it and run again") from None


def _estimate(named: Named, identity: str) -> float:
    hypothesis, explainer = Hypothesis.from_identity(identity), named.explainer
    causes, columns = named.explanation.causes, explainer.evidence.columns
    k = columns.index(hypothesis) if hypothesis in columns else None
    if k is None or not explainer.evidence.observable[k]:
        return hypothesis.value(explainer.nominal)
    # A cause that stands in for the parameter would leave it undetermined.
    others = (j for j in causes if k not in explainer.alternatives(j, causes))
    return hypothesis.value(with_estimates(explainer, tuple(sorted({k, *others}))))


def _write_references(fold: Diagnosis) -> None:
    write_json(fold.file, reference_values(fold.shots, fold.simulator))


def _read_references(file: Path) -> dict[str, float]:
    values = read_json(file)
    try:
        return {identity: float(values[identity]) for identity in IDENTITIES}
    except (ValueError, KeyError, TypeError):
        raise InputError(file, "has no reference values; remove it and run again") from None
