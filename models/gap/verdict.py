"""The verdict on one data set: its types, its file ``verdict.json`` and the reader of that file.

Importing this module loads no inference code. Read a file from Python with::

    from rallygap.models.gap.verdict import Verdict

    verdict = Verdict.load("verdict.json")

The file's JSON schema is ``verdict.schema.json``, next to this module;
``json_schema`` generates it.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, InstanceOf, ValidationError

from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.location import Located
from rallygap.models.gap.types import Phase

VERSION = 2  # of the file (see ``Verdict.version``); grows when a field changes

Answer = Literal["no_gap", "named", "ambiguous", "unknown"]
Kind = Literal["wrong_value", "missing_effect"]
VariationKind = Literal["drift", "by_side", "between_shots"]
# A physical cause that matters, a fault of the sensor, or structure that is small or unsure.
Role = Literal["leading", "sensor", "minor"]


class VerdictError(ValueError):
    """A file that is not a verdict of this version."""


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Worth(_Part):
    """What a cause is worth alone: how much held-out predictions err more when it is taken out.

    Attributes:
        mm: growth of the root mean square error, mean over horizons; the other causes stay and
            have their maximum-likelihood values without it.
        interval: 95 % interval, paired bootstrap over shots.
    """

    mm: float
    interval: tuple[float, float]


class Check(_Part):
    """One posterior predictive check: a measured size over that of the fitted model.

    Attributes:
        name: what is compared.
        ratio: measured over expected, 1 where the model fits; of labels, their error over the spin;
            of bounces, the standard deviation of the restitution.
        interval: 95 % interval, bootstrap over shots; of bounces, by their number.
        allowed: range of ratios of a model that fits.
    """

    name: Literal["residuals", "prediction", "landing", "labels", "bounces"]
    ratio: float
    interval: tuple[float, float]
    allowed: tuple[float, float]

    @property
    def passed(self) -> bool:
        """Whether the interval has part of the allowed range."""
        return self.interval[0] <= self.allowed[1] and self.interval[1] >= self.allowed[0]


class CameraNodes(_Part):
    """The estimated position-dependent camera error, as ``camera_distortion`` has it.

    Attributes:
        length: m, over which it is correlated.
        nodes: places (m) and weights, six numbers each.
    """

    length: float
    nodes: tuple[tuple[float, float, float, float, float, float], ...]


class Cause(_Part):
    """One cause of the gap.

    Attributes:
        identity: ``effect.parameter``, such as ``drag.cd`` or ``wind.x``.
        role: a leading cause, a fault of the sensor, or minor structure, which is not amended.
        kind: whether the simulator has the effect with a wrong value, or lacks it.
        unit: of nominal, estimate and interval.
        nominal: the simulator's value, neutral where it lacks the effect.
        estimate: value by the shots.
        interval: 95 % confidence interval of the estimate.
        p_value: probability that the largest of all hypotheses is as large without any gap.
        gap_share: share of the mean squared discrepancy of trajectories, of all causes and of
            unexplained structure; zero for the net, where these trajectories end.
        worth: alone, in prediction errors; None where held-out shots are too short or few.
        possible: identities that these shots cannot tell from the cause, its own first.
    """

    identity: str
    role: Role = "leading"
    kind: Kind
    unit: str
    nominal: float
    estimate: float
    interval: tuple[float, float]
    p_value: float
    gap_share: float
    worth: Worth | None = None
    possible: tuple[str, ...]

    @property
    def effect(self) -> str:
        """Name of the effect."""
        return self.identity.partition(".")[0]

    @property
    def hypothesis(self) -> Hypothesis:
        """The parameter in question, with its unit and bounds.

        Raises:
            ValueError: the catalogue of this installation does not have it.
        """
        return Hypothesis.from_identity(self.identity)

    @property
    def alternatives(self) -> tuple[str, ...]:
        """Identities of the other possible causes."""
        return tuple(identity for identity in self.possible if identity != self.identity)

    @property
    def ambiguous(self) -> bool:
        """Whether it could be another quantity; the components of a vector are one quantity."""
        return len({Hypothesis(*name.split(".", 1)).quantity for name in self.possible}) > 1


class Variation(_Part):
    """A parameter that is not the same in all shots.

    Attributes:
        identity: ``effect.parameter``.
        kind: whether it drifts over the session, differs between the sides of the net, or from
            shot to shot.
        unit: of size and interval.
        size: the change from the first shot to the last, or from y < 0 to y > 0, or the standard
            deviation.
        interval: 95 % confidence interval of the size.
        p_value: of so much variation without any.
        possible: identities whose variation is about as likely, its own first.
    """

    identity: str
    kind: VariationKind
    unit: str
    size: float
    interval: tuple[float, float]
    p_value: float
    possible: tuple[str, ...]


class Unexplained(_Part):
    """Structure in the residuals that no effect of the catalogue explains.

    Attributes:
        share: of the gap.
        p_value: probability of as much structure without any.
        phase: where most of it arises; None where it is not significant.
        formula: a sparse formula for it; a candidate, not a cause.
    """

    share: float
    p_value: float
    phase: Phase | None = None
    formula: str | None = None


class PhaseShares(_Part):
    """Shares of the gap that arise in flight, at the table and in the sensor."""

    flight: float
    table: float
    sensor: float


class Landing(_Part):
    """Root mean square errors of the predicted place and time of landing.

    Attributes:
        shots: number of shots that land.
        before_mm: of places, by the nominal simulator.
        after_mm: by the amended simulator.
        floor_mm: by a correct simulator (prediction floor).
        before_ms: of times, by the nominal simulator.
        after_ms: by the amended simulator.
        floor_ms: by a correct simulator (prediction floor).
        reduction_mm: 95 % interval of before less after, paired bootstrap over shots.
        reduction_ms: the same of times.
    """

    shots: int
    before_mm: float
    after_mm: float
    floor_mm: float
    before_ms: float
    after_ms: float
    floor_ms: float
    reduction_mm: tuple[float, float]
    reduction_ms: tuple[float, float]

    @property
    def sizes(self) -> tuple[tuple[float, float], ...]:
        """Errors in mm and in ms: before, after and floor."""
        return (
            (self.before_mm, self.before_ms),
            (self.after_mm, self.after_ms),
            (self.floor_mm, self.floor_ms),
        )


class Gap(_Part):
    """Prediction errors on held-out shots, by the nominal and by the amended simulator.

    Attributes:
        horizons_ms: after the last sample that a prediction uses.
        before_mm: root mean square error of the nominal simulator.
        after_mm: of the amended simulator.
        floor_mm: of a correct simulator, with the estimated launches, scatter and noise.
        removable_closed: share of the difference between before and floor that was closed; None
            where there is no difference.
        removable_closed_interval: 95 % interval, bootstrap over shots.
        landing: errors at landing; None where too few shots land.
        before_interval_mm: 95 % interval of each of ``before_mm``, paired bootstrap over shots.
        after_interval_mm: 95 % interval of each of ``after_mm``, by the same resamples.
        reduction_mm: 95 % interval of before less after, mean over horizons, same resamples.
    """

    horizons_ms: tuple[int, ...]
    before_mm: tuple[float, ...]
    after_mm: tuple[float, ...]
    floor_mm: tuple[float, ...]
    removable_closed: float | None
    removable_closed_interval: tuple[float, float] | None
    landing: Landing | None = None
    before_interval_mm: tuple[tuple[float, float], ...] = ()
    after_interval_mm: tuple[tuple[float, float], ...] = ()
    reduction_mm: tuple[float, float] | None = None


class NetErrors(_Part):
    """Prediction errors after the face of the net, by the amended simulator.

    Attributes:
        contacts: number of contacts that the net's values are from, held-out ones included.
        held_out: number of those that the errors are from.
        horizon_ms: after the contact; errors are over the path up to there.
        before_mm: root mean square error with the nominal simulator's net, or none.
        after_mm: with the net as named.
    """

    contacts: int
    held_out: int
    horizon_ms: int
    before_mm: float
    after_mm: float


@dataclass(frozen=True)
class DetectionLimits:
    """What the shots can show, known before causes are searched for.

    Attributes:
        minimum_detectable: minimum detectable effect (5.8 sigma) of every identifiable parameter,
            by identity, in the parameter's unit.
        not_identifiable: identities of parameters about which the shots say nothing.
    """

    minimum_detectable: dict[str, float]
    not_identifiable: tuple[str, ...]


class MadeFrom(_Part):
    """What a verdict was made from.

    Attributes:
        data: name of the source of the shots.
        folder: name of the folder of the recordings; None for a source of the pipeline.
        recordings: number of recordings.
        shots: number of shots, those held out included.
        simulator: name of the nominal simulator, or of its file.
        effects: of the nominal simulator, with their parameters.
        settings: ``level``, the probability of a false cause where there is no gap.
        version: of rallygap.
    """

    data: str
    folder: str | None
    recordings: int
    shots: int
    simulator: str
    effects: dict[str, dict[str, Any]]
    settings: dict[str, Any]
    version: str


class Verdict(_Part):
    """The verdict on one data set.

    Attributes:
        version: of the file's format.
        verdict: in one word.
        causes: of the gap: leading ones, sensor faults and minor structure, each the largest
            share first.
        variations: parameters that are not the same in all shots.
        unexplained: structure that no cause explains.
        phases: shares of the gap by phase.
        gap: prediction errors on held-out shots; None where these are too few.
        net: prediction errors after the net; None where too few shots touch its face.
        checks: posterior predictive checks of the model with the main causes.
        camera: the position-dependent camera error, where it is one of the causes.
        minimum_detectable: see ``DetectionLimits``.
        not_identifiable: see ``DetectionLimits``.
        limitations: sentences: what these data cannot decide, why, and which experiment would.
        made_from: data, simulator and settings; None where ``diagnose`` is called alone.
        located: discrepancy over the horizon and against covariates; not in the file, None there.
    """

    version: Literal[2] = 2
    verdict: Answer
    causes: tuple[Cause, ...]
    variations: tuple[Variation, ...] = ()
    unexplained: Unexplained
    phases: PhaseShares
    gap: Gap | None
    net: NetErrors | None = None
    checks: tuple[Check, ...] = ()
    camera: CameraNodes | None = None
    minimum_detectable: dict[str, float]
    not_identifiable: tuple[str, ...]
    limitations: tuple[str, ...] = ()
    made_from: MadeFrom | None = None
    located: InstanceOf[Located] | None = Field(default=None, exclude=True)

    @property
    def main_causes(self) -> tuple[Cause, ...]:
        """Leading causes and sensor faults: what the verdict names and ``amended.yaml`` has."""
        return tuple(cause for cause in self.causes if cause.role != "minor")

    @property
    def leading(self) -> tuple[Cause, ...]:
        """Causes in the simulator that matter."""
        return tuple(cause for cause in self.causes if cause.role == "leading")

    @property
    def misfits(self) -> tuple[Check, ...]:
        """Checks that fail."""
        return tuple(check for check in self.checks if not check.passed)

    def to_json(self) -> str:
        """Return the content of ``verdict.json``."""
        return json.dumps(self.model_dump(mode="json"), indent=2) + "\n"

    @classmethod
    def from_json(cls, text: str) -> "Verdict":
        """Return the verdict from the content of a ``verdict.json``.

        Raises:
            VerdictError: it is of another version, or not a verdict at all.
        """
        try:
            content = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise VerdictError(f"is not JSON: {error}") from None
        version = content.get("version") if isinstance(content, dict) else None
        if version != VERSION:
            given = "no version" if version is None else f"version {version!r}"
            problem = f"has {given}, and version {VERSION} is read; diagnose again to write it"
            raise VerdictError(problem)
        try:
            return cls.model_validate_json(text)
        except ValidationError as error:
            first = error.errors()[0]
            place = ".".join(map(str, first["loc"]))
            raise VerdictError(f"{place}: {first['msg']}") from None

    @classmethod
    def load(cls, path: Path | str) -> "Verdict":
        """Return the verdict of a ``verdict.json``.

        Raises:
            VerdictError: the file is missing, of another version, or not a verdict; the message
                starts with the path.
        """
        try:
            return cls.from_json(Path(path).read_text(encoding="utf-8"))
        except OSError as error:
            raise VerdictError(f"{path}: cannot be read: {error.strerror}") from None
        except ValueError as error:
            raise VerdictError(f"{path}: {error}") from None


def json_schema() -> str:
    """Return the JSON schema of ``verdict.json``, as committed in ``verdict.schema.json``."""
    return json.dumps(Verdict.model_json_schema(mode="serialization"), indent=2) + "\n"
