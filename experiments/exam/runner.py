"""The scoring path: a question is posed, methods answer, and the record adds the truth.

A method receives the recordings, the nominal simulator and the withheld effects, and nothing else.
The sealed truth stays in this module, which reads it only after all methods have answered.

The removable gap is the distance between simulated and true trajectories, all else equal. New
launches that no recording contains are rolled out without scatter from their true states. Their
noise-free measurements are compared with those that a simulator predicts from the same launches.
The floor is zero: a perfect simulator leaves nothing. The gap is the root mean square distance over
the balls, averaged over the horizons. It is linear in the size of an error, so an estimate that is
5 % off leaves 5 % of the gap.
"""

import time
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from experiments.exam.design.detection_limits import DetectionLimits
from experiments.exam.design.question import Question
from experiments.exam.interface import Answer, Method
from experiments.exam.records import AnswerRecord, ExamRecord, HiddenCause
from experiments.exam.simulate.recordings import MARGIN, SealedTruth, simulate_trial
from experiments.exam.simulate.scattered_shots import scattered_shots
from experiments.exam.simulate.trial import Trial
from rallygap.models.arena.bounce_scatter import BounceScatter
from rallygap.models.audit.launches import launches
from rallygap.models.ball.sensor import measured
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats

BALLS = 100
HORIZONS = np.arange(0.1, 0.65, 0.1)  # s after the launch; the bounce is at 0.2 to 0.4 s
HELD_OUT = 5  # stream of random numbers; the recordings use 0 to 4

NOT_DETECTABLE = "these shots do not show it at any value that makes sense"


class RemovableGap:
    """The gap between simulators and the environment of one trial, on held-out launches."""

    def __init__(self, truth: SealedTruth) -> None:
        trial = truth.trial
        random = np.random.default_rng([trial.seed, HELD_OUT])
        self._drawn = launches(trial.base, BALLS, trial.directions, random)
        shots = scattered_shots(
            truth.shots.ball,
            trial.simulator,
            self._drawn.states,
            np.maximum(self._drawn.durations, HORIZONS[-1]) + MARGIN,
            BounceScatter(restitution=0.0, friction=0.0),
            random,
        )
        self._true = self._positions(shots)

    def remaining(self, simulator: Simulator) -> float:
        """Return the gap between a simulator and the environment in mm."""
        return self._distance(self._positions(simulator), self._true)

    def between(self, first: Simulator, second: Simulator) -> float:
        """Return the gap between two simulators in mm."""
        return self._distance(self._positions(first), self._positions(second))

    def _distance(self, positions: Floats, others: Floats) -> float:
        squared = ((positions - others) ** 2).sum(axis=2)
        flying = self._drawn.durations[:, None] >= HORIZONS
        mean = (squared * flying).sum(axis=0) / np.maximum(flying.sum(axis=0), 1)
        return 1000.0 * float(np.sqrt(mean).mean())

    def _positions(self, simulator: Simulator) -> Floats:
        # Draws only the flipped spin labels, which do not change positions.
        unused = np.random.default_rng(0)
        positions, _ = measured(simulator, self._drawn.states, HORIZONS, unused)
        return positions


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
