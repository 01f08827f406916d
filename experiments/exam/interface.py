"""What a method of the exam receives, and what it answers. Nothing here knows the truth."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.verdict import Answer as Conclusion
from rallygap.models.gap.verdict import Role


def rounded(value: float) -> float:
    """Return a number rounded to six digits: further ones differ between processors."""
    return float(f"{value:.6g}")


Number = Annotated[float, AfterValidator(rounded)]


class Record(BaseModel):
    """Base of what the exam keeps in files: immutable, no further fields, finite numbers."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


@dataclass(frozen=True)
class Recording:
    """What cameras deliver of one shot."""

    times: Floats  # (N,) s on the cameras' clock, rising
    positions: Floats  # (N, 3) m
    label_times: Floats  # (L,) s of the spin labels, L = 0 without labels
    labels: Floats  # (L, 3) rad/s


class NamedCause(Record):
    """One cause that a method names."""

    identity: str  # effect.parameter, such as drag.cd
    estimate: Number  # its value, in the parameter's unit
    # 95 % confidence interval; None where the method has none
    interval: tuple[Number, Number] | None
    possible: tuple[str, ...]  # identities that the method cannot distinguish, its own first
    role: Role = "leading"  # leading cause, fault of the sensor, or minor structure


@dataclass(frozen=True)
class Answer:
    """What a method answers."""

    conclusion: Conclusion  # as in a verdict: no_gap, named, ambiguous or unknown
    causes: tuple[NamedCause, ...]  # that it names
    amended: Simulator  # the nominal simulator with these causes


# From recordings, the nominal simulator, and the effects that are withheld from the catalogue.
Method = Callable[[Sequence[Recording], Simulator, tuple[str, ...]], Answer]


def shots_of(recordings: Sequence[Recording]) -> Shots:
    """Return recordings as the shots that the gap workflow reads."""
    return Shots.from_arrays(
        [recording.times for recording in recordings],
        [recording.positions for recording in recordings],
        [recording.labels for recording in recordings],
        [recording.label_times for recording in recordings],
    )
