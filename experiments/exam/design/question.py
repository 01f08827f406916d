"""A question: a trial whose causes have no size yet.

Sizes are multiples of what the data of a trial can show (``DetectionLimits.minimum_sizes``), and
``Question.posed`` is given them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any
from zlib import crc32

import numpy as np

from experiments.exam.design.parameters import ONLY_INCREASED
from experiments.exam.simulate.laws import supports
from experiments.exam.simulate.trial import Dynamics, Trial
from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.hypotheses import Hypothesis

MULTIPLE = 3.0  # detection limits, unless a group says otherwise
INDEPENDENT_EVERY = 3  # one trial in three has independent dynamics


@dataclass(frozen=True)
class Question:
    """A trial whose causes have no size yet."""

    group: str  # the purpose of the question, and the first part of the trial's name
    trial: Trial  # all but the causes
    hidden: tuple[Hypothesis, ...] = ()  # the parameters to hide; none in a clean set
    multiple: float = MULTIPLE  # size of the causes, in detection limits
    cell: str = ""  # a part of the group, such as one of the sweeps; empty where it has no parts

    @property
    def differences(self) -> tuple[Hypothesis, ...]:
        """Parameters in which the environment differs from the nominal simulator."""
        far_off = self.trial.far_off.items()
        wrong = (Hypothesis(effect, name) for effect, values in far_off for name in values)
        return (*self.hidden, *wrong)

    def posed(self, minimum_sizes: Sequence[float]) -> Trial | None:
        """Return the trial with its causes, or None where a size has no value within bounds."""
        causes: dict[str, dict[str, float]] = {}
        for hidden, size in zip(self.hidden, minimum_sizes, strict=True):
            value = self._value(hidden, self.multiple * size)
            if value is None:
                return None
            causes.setdefault(hidden.effect, {})[hidden.parameter] = value
        return replace(self.trial, causes=causes)

    def _value(self, hidden: Hypothesis, size: float) -> float | None:
        """Return a value ``size`` from the nominal one; the seed decides on which side."""
        sign = 1.0 if seed_of(self.trial.seed, hidden.identity) % 2 else -1.0
        low, high = hidden.declaration.bounds
        for side in (1.0,) if hidden in ONLY_INCREASED else (sign, -sign):
            value = float(hidden.value(self.trial.base) + side * size)
            if low <= value <= high:
                return value
        return None


def seed_of(seed: int, name: str) -> int:
    """Return the seed of what has a name."""
    return int(np.random.SeedSequence([seed, crc32(name.encode())]).generate_state(1)[0])


def question(
    group: str,
    detail: str,
    number: int,
    nominal: Simulator,
    seed: int,
    hidden: tuple[Hypothesis, ...] = (),
    multiple: float = MULTIPLE,
    **settings: Any,
) -> Question:
    """Return a question; its name, and so its seed, follows from its group, parameters and number.

    Args:
        group: the purpose.
        detail: the part of the group, empty where it has no parts.
        number: of the question in its part.
        nominal: the nominal simulator.
        seed: of the exam.
        hidden: the parameters to hide.
        multiple: size of the causes, in detection limits.
        **settings: of the trial.
    """
    parameters = "+".join(parameter.identity for parameter in hidden)
    name = "/".join(part for part in (group, parameters, detail, str(number)) if part)
    supported = all(supports(parameter.effect) for parameter in hidden)
    independent = supported and number % INDEPENDENT_EVERY == 0
    dynamics: Dynamics = "independent" if independent else "catalogue"
    trial = Trial(name, nominal, dynamics=dynamics, seed=seed_of(seed, name), **settings)
    return Question(group, trial, hidden, multiple, detail)
