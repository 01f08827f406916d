"""The plan of a sweep: what it tries, and the parameters of each of its trials."""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from pipeline.experiments.profiles import merged
from pipeline.io.simulators import load_simulator
from pipeline.params import Params, as_json, check_params, load_params, read_yaml
from pipeline.runtime.errors import InputError
from pipeline.runtime.provenance import provenance, short
from pipeline.sweeps.settings import SWEEPS, PolicySweep, PredictorSweep, Value

if TYPE_CHECKING:
    from optuna.trial import BaseTrial

# Validation windows hide the spin as often: losses of different shares do not compare.
JUDGED_BY = {"train_predictor.training.hidden_spin"}


@dataclass(frozen=True)
class Plan:
    """A sweep's settings and the parameters that it starts from.

    Attributes:
        root: of the repository.
        name: of the sweep, as the file ``profiles/sweeps/<name>.yaml``.
        settings: what it says.
        params: what params.yaml says.
    """

    root: Path
    name: str
    settings: PredictorSweep | PolicySweep
    params: dict[str, Any]

    @property
    def path(self) -> Path:
        """The file of the settings."""
        return sweep_path(self.root, self.name)

    @property
    def report(self) -> Path:
        """The folder of what the sweep found."""
        return self.root / "reports" / "sweeps" / self.name

    @property
    def scratch(self) -> Path:
        """The folder of what its workers need."""
        return self.root / "scratch" / "sweeps" / self.name

    @property
    def fingerprint(self) -> str:
        """SHA-256 over the space and all that a trial depends on: code, data, other parameters.

        Trials of one fingerprint compare. How many there are to be is not part of it.
        """
        origin = provenance(self.root, self.settings.stage).fingerprint
        settings = self.settings.model_dump_json(exclude={"trials"})
        return hashlib.sha256((origin + settings).encode()).hexdigest()

    @property
    def study(self) -> str:
        """The name of the study: other data or another space make another study."""
        return f"{self.name}-{short(self.fingerprint)}"

    def defaults(self) -> dict[str, Value] | None:
        """Return what params.yaml says of the parameters to be found; None if out of the space."""
        values = {key: found(self.params, key) for key in self.settings.space}
        inside = all(one.holds(values[key]) for key, one in self.settings.space.items())
        return values if inside else None

    def suggested(self, trial: "BaseTrial") -> dict[str, Value]:
        """Return what a trial tries."""
        return {key: one.suggested(key, trial) for key, one in self.settings.space.items()}

    def trial_params(self, values: dict[str, Value]) -> Params:
        """Return the parameters of a trial.

        Raises:
            InputError: the values do not go together.
        """
        short = merged(self.params, nested(self.settings.in_trials))
        return check_params(merged(short, nested(values)), self.path)


def sweep_path(root: Path, name: str) -> Path:
    """The file of a sweep's settings."""
    return root / "profiles" / "sweeps" / f"{name}.yaml"


def load_plan(root: Path, name: str) -> Plan:
    """Read a sweep's settings, and check them against params.yaml.

    Raises:
        InputError: there is no such file, or it is not what it should be.
    """
    path = sweep_path(root, name)
    if not path.is_file():
        names = sorted(file.stem for file in path.parent.glob("*.yaml"))
        raise InputError(path, f"there is no such sweep; there are: {', '.join(names)}")
    try:
        settings = SWEEPS.validate_json(as_json(read_yaml(path), path), strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"])
        raise InputError(path, first["msg"], field=field) from None
    load_params(root / "params.yaml")
    plan = Plan(root, name, settings, read_yaml(root / "params.yaml"))
    _check(plan)
    return plan


def _check(plan: Plan) -> None:
    """Refuse parameters that are not there or not the sweep's to find, and values out of bounds."""
    settings = plan.settings
    places = [place.rstrip(".") for place in settings.places]
    for key in (*places, *settings.in_trials, *settings.space):
        found(plan.params, key, plan.path)
    if isinstance(settings, PolicySweep):
        load_simulator(settings.simulator)
    for key, parameter in settings.space.items():
        if not key.startswith(settings.places) or key in JUDGED_BY:
            problem = f"is not the sweep's to find; it may find those of {' and '.join(places)}"
            raise InputError(plan.path, problem, field=key)
        for value in parameter.extremes:
            plan.trial_params({key: value})


def found(params: dict[str, Any], key: str, path: Path = Path("params.yaml")) -> Any:
    """Return the parameter of a dotted name.

    Raises:
        InputError: params.yaml has none of that name; ``path`` is who asks.
    """
    value: Any = params
    for part in key.split("."):
        if not isinstance(value, dict) or part not in value:
            raise InputError(path, "is no parameter in params.yaml", field=key)
        value = value[part]
    return value


def nested(values: dict[str, Any]) -> dict[str, Any]:
    """Return dotted names as groups within groups, as params.yaml has them."""
    groups: dict[str, Any] = {}
    for key, value in values.items():
        *above, last = key.split(".")
        group = groups
        for part in above:
            group = group.setdefault(part, {})
        group[last] = value
    return groups
