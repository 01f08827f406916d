"""Sitting the exam: one question is posed, every method answers, and the truth is written beside.

A method sees the recordings, the nominal simulator and which effects are not in question, and
nothing else. The sealed truth stays in this module, the scoring path, which opens it only for what
a method has answered.
"""

import time
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from models.exam.answer import Finding, Method
from models.exam.design.detectable_sizes import Sight
from models.exam.design.questions import Question
from models.exam.design.trial import HiddenCause, Recording, Trial
from models.exam.names import name_of
from models.exam.record import Answered, Hidden, Named, Sheet
from models.exam.scoring.removable_gap import RemovableGap
from models.exam.simulate.recordings import SealedTruth, held
from models.gap.hypotheses import Hypothesis

Seconds = dict[str, float]  # of the processor, by method

NOT_SHOWN = "these shots do not show it at any value that makes sense"


def sit(question: Question, methods: Mapping[str, Method]) -> tuple[Sheet, Seconds]:
    """Pose a question to methods.

    Returns:
        Its sheet, and the CPU seconds that each method took.
    """
    sight = Sight.of(question.trial) if question.asked else None
    try:
        trial = question.posed(lambda _, names: sight.detectable(names) if sight else ())
        if trial is None:
            return _sheet(question, not_posed=NOT_SHOWN), {}
        recordings, truth = held(trial)
    except (RuntimeError, np.linalg.LinAlgError) as error:  # no independent world is like it
        return _sheet(question, not_posed=str(error)), {}
    asked = {name: _asked(one, recordings, trial) for name, one in methods.items()}
    seconds = {name: spent for name, (_, spent) in asked.items()}
    found = {name: finding for name, (finding, _) in asked.items()}
    return _marked(question, truth, found, sight), seconds


def _asked(
    method: Method, recordings: tuple[Recording, ...], trial: Trial
) -> tuple[Finding | Exception, float]:
    """Return what a method finds, or why it fails, and the CPU seconds that takes."""
    start = time.process_time()
    found: Finding | Exception
    try:
        found = method(recordings, trial.nominal, trial.withheld)
    except Exception as error:  # whatever it is, it is the method's
        found = error
    return found, time.process_time() - start


def _marked(
    question: Question,
    truth: SealedTruth,
    found: Mapping[str, Finding | Exception],
    sight: Sight | None,
) -> Sheet:
    gap = RemovableGap(truth) if sight else None
    answers = {name: _answered(finding, gap) for name, finding in found.items()}
    if not (sight and gap):
        return _sheet(question, answers=answers)
    hidden = tuple(_hidden(cause, truth.trial, sight) for cause in truth.trial.hidden)
    before = gap.left(truth.trial.nominal)
    return _sheet(question, hidden=hidden, before_mm=before, answers=answers)


def _answered(finding: Finding | Exception, gap: RemovableGap | None) -> Answered:
    try:
        if isinstance(finding, Exception):
            raise finding
        causes = tuple(Named(**asdict(one)) for one in finding.causes)
        after = gap.left(finding.amended) if gap else None
        return Answered(answer=finding.answer, causes=causes, after_mm=after)
    except Exception as error:  # what is no number, or cannot be flown, is no answer
        return Answered(answer=None, error=f"{type(error).__name__}: {error}")


def _hidden(cause: HiddenCause, trial: Trial, sight: Sight) -> Hidden:
    name = (cause.effect, cause.parameter)
    others = tuple((one.effect, one.parameter) for one in trial.hidden if one != cause)
    return Hidden(
        name=name_of(Hypothesis(*name)),
        effect=cause.effect,
        parameter=cause.parameter,
        kind=cause.kind,
        nominal=cause.nominal,
        value=cause.value,
        alike=sight.alike(name, cause.value - cause.nominal, others),
    )


def _sheet(question: Question, **content: Any) -> Sheet:
    trial = question.trial
    return Sheet(
        name=trial.name,
        group=question.group,
        cell=question.cell,
        world=trial.world,
        multiple=question.multiple,
        shots=trial.shots,
        noise=trial.cameras.position_noise,
        spin_labels=trial.spin_labels,
        directions=trial.directions,
        withheld=trial.withheld,
        asked=tuple(f"{effect}.{parameter}" for effect, parameter in question.asked),
        **content,
    )
