"""The scoring path: a question is posed, methods answer, and the record adds the truth.

A method receives the recordings, the nominal simulator and the withheld effects, and nothing else.
The sealed truth stays in this module, which reads it only after all methods have answered.
"""

import time
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from rallygap.models.exam.design.detection_limits import DetectionLimits
from rallygap.models.exam.design.question import Question
from rallygap.models.exam.interface import Answer, Method
from rallygap.models.exam.records import AnswerRecord, ExamRecord, HiddenCause
from rallygap.models.exam.scoring.removable_gap import RemovableGap
from rallygap.models.exam.simulate.recordings import simulate_trial
from rallygap.models.exam.simulate.trial import Trial

NOT_DETECTABLE = "these shots do not show it at any value that makes sense"


def run_question(question: Question, methods: Mapping[str, Method]) -> ExamRecord:
    """Pose a question to methods and return its record."""
    limits = DetectionLimits.of(question.trial) if question.hidden else None
    try:
        trial = question.posed(limits.minimum_sizes(question.hidden) if limits else ())
        if trial is None:
            return _record(question, not_posed=NOT_DETECTABLE)
        recordings, truth = simulate_trial(trial)
    except (RuntimeError, np.linalg.LinAlgError) as error:  # no equivalent independent dynamics
        return _record(question, not_posed=str(error))
    answers: dict[str, Answer | Exception] = {}
    seconds: dict[str, float] = {}
    for name, method in methods.items():
        start = time.process_time()
        try:
            answers[name] = method(recordings, trial.nominal, trial.withheld)
        except Exception as error:  # any failure is the method's, and counts as one
            answers[name] = error
        seconds[name] = time.process_time() - start
    constant = trial.variation is None  # otherwise no simulator of the catalogue has no gap
    gap = RemovableGap(truth) if limits and constant else None
    return _record(
        question,
        hidden=tuple(_hidden_causes(question, trial, limits, gap)) if limits else (),
        gap_before_mm=gap.remaining(trial.nominal) if gap else None,
        answers={name: _answer_record(answer, gap) for name, answer in answers.items()},
        seconds=seconds,
    )


def _answer_record(answer: Answer | Exception, gap: RemovableGap | None) -> AnswerRecord:
    try:
        if isinstance(answer, Exception):
            raise answer
        after = gap.remaining(answer.amended) if gap else None
        return AnswerRecord(conclusion=answer.conclusion, causes=answer.causes, gap_after_mm=after)
    except Exception as error:  # also a simulator that cannot be rolled out
        return AnswerRecord(conclusion=None, error=f"{type(error).__name__}: {error}")


def _hidden_causes(
    question: Question, trial: Trial, limits: DetectionLimits, gap: RemovableGap | None
) -> Iterator[HiddenCause]:
    """Yield the truth about each cause; its effect is measured where there are several."""
    several = len(question.differences) > 1
    for hidden in question.differences:
        nominal, value = hidden.value(trial.nominal), hidden.value(trial.simulator)
        others = tuple(other for other in question.hidden if other != hidden)
        without = hidden.at(trial.simulator, nominal)
        yield HiddenCause(
            identity=hidden.identity,
            kind="wrong_value" if hidden.listed(trial.nominal) else "missing_effect",
            nominal=nominal,
            value=value,
            indistinguishable=limits.indistinguishable(hidden, value - nominal, others),
            effect_mm=gap.between(trial.simulator, without) if gap and several else None,
        )


def _record(question: Question, **content: Any) -> ExamRecord:
    trial = question.trial
    return ExamRecord(
        name=trial.name,
        group=question.group,
        cell=question.cell,
        dynamics=trial.dynamics,
        multiple=question.multiple,
        shots=trial.shots,
        noise=trial.cameras.position_noise,
        spin_labels=trial.spin_labels,
        directions=trial.directions,
        withheld=trial.withheld,
        parameters=tuple(hidden.identity for hidden in question.differences),
        **content,
    )
