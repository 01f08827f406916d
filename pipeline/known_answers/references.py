"""Reference values: what the recordings of a fold say about parameters before anything is planted.

They are the true values of planted errors. The base simulator's values are those of other
recordings, which may differ: an error planted about them would have another size than it says.
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.fit.shots import Shots, held_out
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.name.naming import Named, name, with_estimates
from rallygap.models.gap.settings import DEFAULTS, Question
from rallygap.pipeline.io.artifacts import read_json, write_json
from rallygap.pipeline.known_answers.answers import Diagnosis
from rallygap.pipeline.known_answers.design import IN_RECORDINGS, IN_SIMULATOR
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.parallel import make_missing

IDENTITIES = (*IN_SIMULATOR, *IN_RECORDINGS, "table_tilt.y")


def references(folds: Sequence[Diagnosis]) -> list[dict[str, float]]:
    """Return the reference values of unplanted folds by identity; those on file are kept.

    Args:
        folds: with files for the values.

    Raises:
        InputError: a file that an earlier run left is broken.
    """
    make_missing({fold.file: partial(_write, fold) for fold in folds}, "reference values")
    return [_read(fold.file) for fold in folds]


def reference_values(shots: Shots, simulator: Simulator) -> dict[str, float]:
    """Return maximum-likelihood values by identity, each with all causes distinguishable from it.

    A parameter that the shots do not show keeps the simulator's value.
    """
    question = Question(simulator, DEFAULTS, ())
    named = name(shots[~held_out(shots, DEFAULTS)], question)
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


def _write(fold: Diagnosis) -> None:
    write_json(fold.file, reference_values(fold.shots, fold.simulator))


def _read(file: Path) -> dict[str, float]:
    values = read_json(file)
    try:
        return {identity: float(values[identity]) for identity in IDENTITIES}
    except (ValueError, KeyError, TypeError):
        raise InputError(file, "has no reference values; remove it and run again") from None
