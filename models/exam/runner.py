"""The scoring path: a question is posed, methods answer, and the record adds the truth.

A method receives the recordings, the nominal simulator and the withheld effects, and nothing else.
The sealed truth stays in this module, which reads it only after all methods have answered.
"""

import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from rallygap.models.exam.design.detection_limits import DetectionLimits
from rallygap.models.exam.design.question import Question
from rallygap.models.exam.interface import Answer, Method, Recording
from rallygap.models.exam.records import AnswerRecord, ExamRecord, HiddenCause
from rallygap.models.exam.scoring.removable_gap import RemovableGap
from rallygap.models.exam.simulate.recordings import simulate_trial
from rallygap.models.exam.simulate.trial import Trial
from rallygap.models.gap.hypotheses import Hypothesis

NOT_DETECTABLE = "these shots do not show it at any value that makes sense"


def run_question(
    question: Question, methods: Mapping[str, Method]
) -> tuple[ExamRecord, dict[str, float]]:
    """Pose a question to methods.

    Returns:
        Its record, and the CPU seconds that each method took.
    """
    limits = DetectionLimits.of(question.trial) if question.hidden else None
    try:
        trial = question.posed(limits.minimum_sizes(question.hidden) if limits else ())
        if trial is None:
            return _record(question, not_posed=NOT_DETECTABLE), {}
        recordings, truth = simulate_trial(trial)
    except (RuntimeError, np.linalg.LinAlgError) as error:  # no equivalent independent dynamics
        return _record(question, not_posed=str(error)), {}
    answers: dict[str, Answer | Exception] = {}
    seconds: dict[str, float] = {}
    for name, method in methods.items():
        answers[name], seconds[name] = _answer(method, recordings, trial)
    constant = trial.variation is None  # otherwise no simulator of the catalogue has no gap
    gap = RemovableGap(truth) if limits and constant else None
    causes = (
        [_hidden_cause(c, question, trial, limits, gap) for c in question.differences]
        if limits
        else []
    )
    record = _record(
        question,
        hidden=tuple(causes),
        gap_before_mm=gap.remaining(trial.nominal) if gap else None,
        answers={name: _answer_record(answer, gap) for name, answer in answers.items()},
    )
    return record, seconds


def _answer(
    method: Method, recordings: tuple[Recording, ...], trial: Trial
) -> tuple[Answer | Exception, float]:
    """Return what a method answers, or why it fails, and the CPU seconds that takes."""
    start = time.process_time()
    answer: Answer | Exception
    try:
        answer = method(recordings, trial.nominal, trial.withheld)
    except Exception as error:  # any failure is the method's, and counts as one
        answer = error
    return answer, time.process_time() - start


def _answer_record(answer: Answer | Exception, gap: RemovableGap | None) -> AnswerRecord:
    try:
        if isinstance(answer, Exception):
            raise answer
        after = gap.remaining(answer.amended) if gap else None
        return AnswerRecord(conclusion=answer.conclusion, causes=answer.causes, gap_after_mm=after)
    except Exception as error:  # also a simulator that cannot be rolled out
        return AnswerRecord(conclusion=None, error=f"{type(error).__name__}: {error}")


def _hidden_cause(
    hidden: Hypothesis,
    question: Question,
    trial: Trial,
    limits: DetectionLimits,
    gap: RemovableGap | None,
) -> HiddenCause:
    """Return the truth about a cause; its effect is measured where there are several."""
    nominal, value = hidden.value(trial.nominal), hidden.value(trial.simulator)
    others = tuple(other for other in question.hidden if other != hidden)
    without = hidden.at(trial.simulator, nominal)
    measured = gap if len(question.differences) > 1 else None
    return HiddenCause(
        identity=hidden.identity,
        kind="wrong_value" if hidden.listed(trial.nominal) else "missing_effect",
        nominal=nominal,
        value=value,
        indistinguishable=limits.indistinguishable(hidden, value - nominal, others),
        effect_mm=measured.between(trial.simulator, without) if measured else None,
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
