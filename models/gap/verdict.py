"""The verdict: what one data set says of the gap between a simulator and measured balls."""

import json
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, InstanceOf

from models.ball.simulator import Simulator
from models.gap.hypotheses import Hypothesis, hypotheses
from models.gap.location import Located

AXES = ("x", "y", "z")
WORSE = 0.02  # of the errors before: by as much more those of causes that mislead are, surely

Answer = Literal["no_gap", "named", "ambiguous", "unknown"]
Kind = Literal["wrong_value", "missing_effect"]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, populate_by_name=True)


class Cause(_Part):
    """One cause of the gap.

    Attributes:
        name: of the effect, or of the number where an effect has several, such as restitution.
        component: the axis of an effect that has one number an axis.
        kind: whether the simulator has the effect with a wrong value, or lacks it.
        parameter: the number, as the simulator's YAML calls it.
        unit: of all values.
        nominal: what the simulator says, neutral where it lacks the effect.
        estimate: what the shots say.
        interval: 95 % of it.
        p_value: chance that the largest of all hypotheses looks as large without any gap.
        gap_share: of all that is wrong.
        possible: the names that these shots cannot tell from it, its own first.
    """

    name: str
    component: str | None
    kind: Kind
    parameter: str
    unit: str
    nominal: float
    estimate: float
    interval: tuple[float, float]
    p_value: float
    gap_share: float
    possible: tuple[str, ...] = Field(alias="class")

    @property
    def others(self) -> tuple[str, ...]:
        """What else it may be."""
        return tuple(name for name in self.possible if name != self.name)


class Unexplained(_Part):
    """What no catalogued effect explains.

    Attributes:
        share: of all that is wrong.
        p_value: chance of so much structure in what is left, were there none.
        where: the phase that shows most of it, where it is significant.
        lead: a sparse formula for it; a lead, not a name.
    """

    share: float
    p_value: float
    where: Literal["flight", "table", "sensor"] | None = None
    lead: str | None = None


class Where(_Part):
    """Shares of the gap that arise in flight, at the table and in the sensor."""

    flight: float
    table: float
    sensor: float


class Landing(_Part):
    """Errors of predictions of where and when balls land, root mean square.

    Attributes:
        shots: that land.
        before_mm: of places, by the simulator as it was.
        after_mm: by the amended simulator.
        floor_mm: by a simulator without fault.
        before_ms: of times, by the simulator as it was.
        after_ms: by the amended simulator.
        floor_ms: by a simulator without fault.
        closer_mm: by how much places got better, 95 %, by shots drawn at random in pairs.
        closer_ms: by how much times got better.
    """

    shots: int
    before_mm: float
    after_mm: float
    floor_mm: float
    before_ms: float
    after_ms: float
    floor_ms: float
    closer_mm: tuple[float, float]
    closer_ms: tuple[float, float]

    @property
    def sizes(self) -> tuple[tuple[float, float], ...]:
        """Errors in mm and in ms: before, after and at the floor."""
        return (
            (self.before_mm, self.before_ms),
            (self.after_mm, self.after_ms),
            (self.floor_mm, self.floor_ms),
        )


class Gap(_Part):
    """Errors of predictions on shots that naming never saw.

    Attributes:
        horizons_ms: after the last sample that a prediction may use.
        before_mm: root mean square error of the simulator as it was.
        after_mm: of the amended simulator.
        floor_mm: of a simulator without fault, by the noise and scatter found.
        removable_closed: share of the gap between before and floor that closed; None where there is
            none to close.
        interval: 95 % of it, by shots drawn at random.
        landing: errors where and when balls land; None where too few do.
        before_interval_mm: 95 % of each of ``before_mm``, by shots drawn at random in pairs.
        after_interval_mm: 95 % of each of ``after_mm``, by the same shots.
        closer_mm: 95 % of by how much errors fell, their mean over horizons, by the same shots.
    """

    horizons_ms: tuple[int, ...]
    before_mm: tuple[float, ...]
    after_mm: tuple[float, ...]
    floor_mm: tuple[float, ...]
    removable_closed: float | None
    interval: tuple[float, float] | None
    landing: Landing | None = None
    before_interval_mm: tuple[tuple[float, float], ...] = ()
    after_interval_mm: tuple[tuple[float, float], ...] = ()
    closer_mm: tuple[float, float] | None = None

    @property
    def worse(self) -> bool:
        """Whether the amended simulator predicts clearly worse, beyond chance.

        The right causes may as well, by a little, where predictions hardly depend on them.
        """
        least = WORSE * float(np.mean(self.before_mm))
        return self.closer_mm is not None and self.closer_mm[1] < -least


class Verdict(_Part):
    """What one data set says.

    Attributes:
        verdict: in one word.
        effects: the causes, those of the largest share first.
        unexplained: what is left.
        where: it arises.
        gap: on shots that naming never saw; None where there are too few.
        detectable: smallest size of every effect that these shots would show, each in its unit.
        blind_to: effects of which they show nothing.
        limits: in words, what these data cannot decide, why, and what would.
        located: how far balls part, and against what that grows; not in the file.
    """

    verdict: Answer
    effects: tuple[Cause, ...]
    unexplained: Unexplained
    where: Where
    gap: Gap | None
    detectable: dict[str, float]
    blind_to: tuple[str, ...]
    limits: tuple[str, ...] = Field(default=(), exclude=True)
    located: InstanceOf[Located] | None = Field(default=None, exclude=True)

    def to_json(self) -> str:
        """Return the content of ``verdict.json``."""
        return json.dumps(self.model_dump(mode="json", by_alias=True), indent=2) + "\n"

    @classmethod
    def from_json(cls, text: str) -> "Verdict":
        """Return the verdict of a ``verdict.json``."""
        return cls.model_validate_json(text)


def name_of(hypothesis: Hypothesis) -> str:
    """Return the catalogue's name of what a number is about."""
    if component_of(hypothesis) or len(hypothesis.siblings) == 1:
        return hypothesis.effect
    return hypothesis.parameter


def component_of(hypothesis: Hypothesis) -> str | None:
    """Return the axis that a number belongs to, if it does."""
    several = len(hypothesis.siblings) > 1
    return hypothesis.parameter if several and hypothesis.parameter in AXES else None


def label_of(hypothesis: Hypothesis) -> str:
    """Return a name that no other number has, such as ``wind.x``."""
    component = component_of(hypothesis)
    return f"{hypothesis.effect}.{component}" if component else name_of(hypothesis)


def hypothesis_of(cause: Cause, simulator: Simulator) -> Hypothesis:
    """Return the number that a cause is about.

    Args:
        cause: of a gap.
        simulator: as it was before the cause was found.
    """
    wanted = cause.name, cause.component, cause.parameter
    return next(
        one
        for one in hypotheses(simulator)
        if (name_of(one), component_of(one), one.parameter) == wanted
    )
