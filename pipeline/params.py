"""The parameters of every stage: read from params.yaml, typed, bounded, or refused by name."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    PositiveInt,
    StringConstraints,
    ValidationError,
    model_validator,
)

from rallygap.models.arena.settings import ArenaSettings
from rallygap.models.policy.settings import (
    DEFAULT_REWARD,
    GoalSettings,
    HorizonsMs,
    LearningSettings,
    RewardSettings,
    SensorNoise,
)
from rallygap.models.predictors.settings import NetworkSettings, TrainingSettings
from rallygap.models.segmentation.settings import ScoringSettings, SegmentSettings
from rallygap.models.shot_quality.settings import ForestSettings
from rallygap.models.support.suggestion import suggestion
from rallygap.models.support.yaml_file import YamlFileError, load_yaml
from rallygap.pipeline.runtime.errors import InputError

# A name that is also a key of metrics, a folder, a file name and a legend entry.
Name = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*$", max_length=40)]

LONGEST_SHOWN = 100  # characters of a refused value in a message


class Settings(BaseModel):
    """A group of parameters: no unknown keys, no silent conversions, no infinities."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def _each_once(names: list[str]) -> list[str]:
    if len(set(names)) < len(names):
        raise ValueError("give each name once")
    return names


class IngestSettings(Settings):
    """Which sources to read, and their folder."""

    folder: Path | None
    """The folder with one folder per source (``spindoe/``, ``tt3d/``, ...); ``None``: that of the
    environment variable ``RALLYGAP_DATA``."""
    sources: Annotated[list[Name], Field(min_length=1), AfterValidator(_each_once)]
    arena: ArenaSettings


class PhysicsPredictorSettings(Settings):
    """An extended Kalman filter over the measured history, then a simulator."""

    kind: Literal["physics", "filterpy_ekf"]
    """Whether the compiled filter or filterpy's, which takes sixteen times as long."""
    simulator: Annotated[str, StringConstraints(min_length=1)]
    """The name of a shipped simulator or the path of a simulator's YAML file."""


class FineTuningSettings(Settings):
    """How trained predictors are fine-tuned on other data sets; their names get a suffix."""

    sources: list[Name]
    """Data sets; an empty list leaves fine-tuning out."""
    epochs: Annotated[int, Field(ge=1, le=10_000)]
    windows_per_episode: Annotated[int, Field(ge=1, le=100)]


class TrainPredictorSettings(Settings):
    """Which predictors are trained, on which data sets, and how."""

    sources: Annotated[list[Name], Field(min_length=1)]
    """Data sets to train on."""
    networks: Annotated[dict[Name, NetworkSettings], Field(min_length=1)]
    training: TrainingSettings
    """The same for every network."""
    fine_tuning: FineTuningSettings


class ComparedSimulatorSettings(Settings):
    """A simulator that measured balls are compared with."""

    simulator: Annotated[str, StringConstraints(min_length=1)]
    """The name of a shipped simulator or the path of a simulator's YAML file ..."""
    without: list[Name]
    """... less these effects."""


class CloseGapSettings(Settings):
    """Which simulators the training shots of every source are compared with, and on how many."""

    simulators: Annotated[dict[Name, ComparedSimulatorSettings], Field(min_length=1)]
    splits: Annotated[int, Field(ge=1, le=100)]
    """Number of random draws of shots: two in three shots for naming, the rest for verifying."""
    shots: Annotated[int, Field(ge=3, le=10_000)]
    """Drawn each time, at most."""
    level: Annotated[float, Field(ge=1e-4, le=0.5)]
    """Probability of a false name where there is no gap."""


class EvaluatePredictorSettings(Settings):
    """Which predictors forecast which windows, and the intervals of their errors.

    Every trained predictor is evaluated, and on the arena the one that knows its truth.
    """

    predictors: Annotated[dict[Name, PhysicsPredictorSettings], Field(min_length=1)]
    """Those that need no training."""
    window_every_ms: Annotated[int, Field(ge=5, le=1000, multiple_of=5)]
    """Windows of one episode start this far apart, on the 200 Hz grid."""
    bootstrap_resamples: Annotated[int, Field(ge=0, le=100_000)]
    """Resamples of the recordings for the confidence intervals; 0 leaves them out."""


class PolicyGroupSettings(Settings):
    """Policies with the same settings: one per simulator, triple of horizons and repeat."""

    simulators: Annotated[list[Name], Field(min_length=1)]
    """Shipped simulators by name."""
    horizons_ms: Annotated[list[HorizonsMs], Field(min_length=1)]
    repeats: Annotated[int, Field(ge=1, le=100)]
    """Policies that differ only in the seed."""
    observation: Literal["intercept", "strict"]
    goals: GoalSettings
    learning: LearningSettings

    @model_validator(mode="after")
    def _names_differ(self) -> "PolicyGroupSettings":
        """Trained policies are filed by simulator and nearest horizon."""
        nearest = [horizons[0] for horizons in self.horizons_ms]
        for names in (self.simulators, nearest):
            if len(set(names)) < len(names):
                raise ValueError(f"simulators and nearest horizons must differ: {names}")
        return self


class TrainPolicySettings(Settings):
    """Which policies learn to return balls, in which simulators, and how."""

    groups: Annotated[dict[Name, PolicyGroupSettings], Field(min_length=1)]
    reward: RewardSettings = DEFAULT_REWARD
    """The same for every group."""
    trials: Annotated[int, Field(ge=10, le=100_000)]
    """Test trials of a trained policy in its own simulator."""


Sim2SimProtocol = Literal["first_state", "re_anchored"]
"""What a simulator predicts the ball from: its first state, or its true state at every control
step."""


class Sim2SimSettings(Settings):
    """Which policies play in another simulator, and from which predictions."""

    ground_truth: Name
    """The shipped simulator that is the ground truth."""
    group: Name
    """The policies that play, of ``train_policy``."""
    episodes: Annotated[int, Field(ge=1, le=100_000)]
    """Balls, the same for every policy."""
    protocols: Annotated[list[Sim2SimProtocol], Field(min_length=1), AfterValidator(_each_once)]


class ToleranceSettings(Settings):
    """Which errors are added to forecasts, to measure what policies tolerate."""

    shots: Annotated[int, Field(ge=1, le=100_000)]
    """Of the policies' own simulator, the same for all errors."""
    errors_cm: Annotated[list[Annotated[float, Field(ge=0, le=100)]], Field(min_length=1)]
    """Of the forecast positions."""


class Sim2RealSettings(Settings):
    """Which policies play measured trajectories, and how launches are made into trajectories."""

    group: Name
    """The policies that play, of ``train_policy``, ..."""
    simulator: Name
    """... and of those the ones from this simulator, with which physics forecasts."""
    learned: Annotated[list[Name], Field(min_length=1), AfterValidator(_each_once)]
    """The trained predictors that forecast, too."""
    launches: Annotated[int, Field(ge=1, le=100_000)]
    """Drawn from every source of launches, at most."""
    noise: SensorNoise
    """Of what is measured of their flights, and of all balls where their recordings end."""
    tolerance: ToleranceSettings


class ShotQualitySettings(Settings):
    """How the forest that estimates winning probabilities is trained and validated."""

    forest: ForestSettings
    folds: Annotated[int, Field(ge=2, le=100)]
    """Of the cross-validation; each match is in one fold."""
    points: Annotated[int, Field(ge=10, le=1_000_000)]
    """Simulated between a professional and each receiver of the sensitivity analysis."""
    bootstrap_resamples: Annotated[int, Field(ge=0, le=100_000)]
    """Resamples of balls and matches for the confidence intervals; 0 leaves them out."""


class RetrainPolicySettings(Settings):
    """In which amended simulators policies are re-trained, to play the same shots."""

    sources: Annotated[list[Name], Field(min_length=1)]
    """Data sets: policies are re-trained for each, and play its shots."""


class ExamSettings(Settings):
    """The simulator of the exam, and which of its questions other methods answer, too."""

    simulator: Annotated[str, StringConstraints(min_length=1)]
    """The nominal one: a shipped one's name, or the path of a YAML file with a table."""
    edition: Annotated[int, Field(ge=1, le=1000)]
    """Of the exam; the questions of each are drawn with another seed."""
    other_methods_every: Annotated[int, Field(ge=1, le=1000)]
    """One question in so many is also answered by the other methods."""


class ReportSettings(Settings):
    """How much the page shows."""

    shots: Annotated[int, Field(ge=0, le=20)]
    """Measured shots in the 3-D view, at most."""
    returns: Annotated[int, Field(ge=0, le=40)]
    """Returns by policies in the other 3-D view, at most."""


class Params(Settings):
    """The content of params.yaml."""

    seed: Annotated[int, Field(ge=0, lt=2**32)]
    cores: PositiveInt | None = None
    ingest: IngestSettings
    segment: SegmentSettings
    score_segmentation: ScoringSettings
    train_predictor: TrainPredictorSettings
    close_gap: CloseGapSettings
    evaluate_predictor: EvaluatePredictorSettings
    train_policy: TrainPolicySettings
    sim2sim: Sim2SimSettings
    sim2real: Sim2RealSettings
    shot_quality: ShotQualitySettings
    retrain_policy: RetrainPolicySettings
    exam: ExamSettings
    report: ReportSettings


# Keys of kept runs that have other names today.
FORMER_KEYS = {
    "states_a_row": "states_per_row",
    "windows_an_episode": "windows_per_episode",
    "longest_gradient": "max_gradient_norm",
}


def with_current_keys(content: Any) -> Any:
    """Return the parameters of a kept run under today's keys."""
    if not isinstance(content, dict):
        return content
    return {FORMER_KEYS.get(key, key): with_current_keys(value) for key, value in content.items()}


class ParameterError(InputError):
    """Everything that is wrong with a parameter file, one line a problem."""

    def __init__(self, problems: Sequence[InputError]) -> None:
        first = problems[0]
        super().__init__(first.where, first.problem, field=first.field)
        self.args = ("\n".join(str(problem) for problem in problems),)


def read_yaml(path: Path) -> Any:
    """Read a YAML file.

    Raises:
        InputError: the file is missing or is not YAML.
    """
    try:
        return load_yaml(path)
    except YamlFileError as error:
        raise InputError(path, str(error)) from None


def as_json(content: Any, path: Path) -> str:
    """Write YAML's content as JSON.

    Strict JSON is the stage between lax (the text "3" passes as a number) and strict Python (a YAML
    list would be no tuple).

    Raises:
        InputError: ``path`` holds what JSON cannot, such as a date as a key.
    """
    try:
        return json.dumps(content, default=str)
    except (TypeError, ValueError, RecursionError) as error:
        raise InputError(path, f"is not plain YAML: {error}") from None


def load_params(path: Path) -> Params:
    """Read and check a parameter file.

    Raises:
        InputError: naming every key at fault, what is wrong with it and what is allowed.
    """
    return check_params(read_yaml(path), path)


def check_params(content: Any, path: Path) -> Params:
    """Check parameters that were read from ``path``; see ``load_params``."""
    try:
        return Params.model_validate_json(as_json(content, path), strict=True)
    except ValidationError as error:
        problems = [
            InputError(path, _explanation(details), field=_key(details, content))
            for details in error.errors()
        ]
        raise ParameterError(problems) from None


def _key(details: Any, content: Any) -> str | None:
    """Return the dotted key of what is wrong in ``content``.

    Pydantic's locations also name the kind that tells settings apart, which is no key.
    """
    keys = []
    for number, part in enumerate(details["loc"], start=1):
        try:
            content = content[part]
        except (LookupError, TypeError):
            if details["type"] != "missing" or number < len(details["loc"]):
                continue
        keys.append(str(part))
    return ".".join(keys) or None


def _explanation(details: Any) -> str:
    location = details["loc"]
    if details["type"] == "extra_forbidden":
        return f"is an unknown key; {suggestion(location[-1], sorted(_known_keys(location[:-1])))}"
    if details["type"] == "missing":
        return "is missing"
    message = details["msg"][0].lower() + details["msg"][1:]
    text = json.dumps(details["input"], ensure_ascii=False)
    return f"{message}, not {text[:LONGEST_SHOWN]}{'…' if len(text) > LONGEST_SHOWN else ''}"


def _known_keys(location: Sequence[int | str]) -> set[str]:
    """The keys allowed at a place in the parameters; names of users' own choice are skipped."""
    models: list[type[BaseModel]] = [Params]
    of_kind = []
    for part in location:
        fields = [model.model_fields[part] for model in models if part in model.model_fields]
        if fields:
            models = [model for field in fields for model in _models_in(field.annotation)]
        kinds = ((model, model.model_fields.get("kind")) for model in models)
        of_kind = [model for model, kind in kinds if kind and part in get_args(kind.annotation)]
    return {name for model in of_kind or models for name in model.model_fields}


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in get_args(annotation):
        yield from _models_in(argument)
