"""The predictors that are evaluated: physics, amended physics, the oracle and trained networks."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rallygap.models.ball.simulator import Simulator
from rallygap.models.predictors.filterpy_ekf import FilterpyPredictor
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.models.predictors.protocol import ProbabilisticPredictor
from rallygap.pipeline.io.amended_simulators import AMENDED, read_amended
from rallygap.pipeline.io.ground_truth import read_truth
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import EvaluatePredictorSettings
from rallygap.pipeline.predictors.storage import DESCRIPTION, load_predictor, read_description
from rallygap.pipeline.runtime.errors import InputError

ORACLE, ARENA = "oracle", "arena"
PHYSICS_BY_KIND: dict[str, Callable[[Simulator], PhysicsPredictor]] = {
    "physics": PhysicsPredictor,
    "filterpy_ekf": FilterpyPredictor,
}


@dataclass(frozen=True)
class NamedPredictor:
    """A predictor with its description.

    Attributes:
        name: in reports.
        predictor: forecasts, and says how sure it is.
        kind: ``physics``, ``filterpy_ekf``, ``amended``, ``oracle`` or the kind of network.
        simulator: of its flight model, if any.
        parameters: number of trained parameters, if any.
        trained_on: data sets that it was last trained or amended on.
        starts_from: the predictor that was fine-tuned, if any.
    """

    name: str
    predictor: ProbabilisticPredictor
    kind: str
    simulator: str | None = None
    parameters: int | None = None
    trained_on: tuple[str, ...] = ()
    starts_from: str | None = None

    def forecasts(self, source: str) -> bool:
        """Return whether it is evaluated on a set; oracle and amended physics are not on all."""
        known = {ORACLE: (ARENA,), AMENDED: self.trained_on}
        return self.kind not in known or source in known[self.kind]


def read_predictors(artifacts: Path, settings: EvaluatePredictorSettings) -> list[NamedPredictor]:
    """Return all predictors.

    Args:
        artifacts: the folder of all stages' artefacts.
        settings: name those without training.

    Raises:
        InputError: a simulator, a trained predictor or the truth is missing or invalid.
    """
    return [
        *_physics(settings),
        *_amended(artifacts / "close_gap"),
        *_oracle(artifacts / "ingest" / "truth.json"),
        *read_trained(artifacts / "train_predictor"),
    ]


def _physics(settings: EvaluatePredictorSettings) -> Iterator[NamedPredictor]:
    for name, described in settings.predictors.items():
        predictor = PHYSICS_BY_KIND[described.kind](load_simulator(described.simulator))
        yield NamedPredictor(name, predictor, described.kind, simulator=described.simulator)


def _amended(folder: Path) -> Iterator[NamedPredictor]:
    for amendment in read_amended(folder):
        effects = amendment.simulator.effects
        variants = {"": amendment.simulator}
        if "net" in effects:
            rest = {name: values for name, values in effects.items() if name != "net"}
            variants["_without_net"] = Simulator(rest)
        for suffix, simulator in variants.items():
            yield NamedPredictor(
                f"{AMENDED}_{amendment.base}{suffix}",
                PhysicsPredictor(simulator),
                AMENDED,
                simulator=f"{amendment.base}, amended{suffix.replace('_', ' ')}",
                trained_on=(amendment.source,),
            )


def _oracle(path: Path) -> Iterator[NamedPredictor]:
    truth = read_truth(path)
    if truth is not None:
        predictor = PhysicsPredictor(truth.simulator)
        yield NamedPredictor(ORACLE, predictor, ORACLE, simulator="the arena's truth")


def read_learned(folder: Path, names: Sequence[str]) -> list[NamedPredictor]:
    """Return the trained predictors of a folder that ``sim2real.learned`` names.

    Raises:
        InputError: one is missing or invalid.
    """
    trained = {predictor.name: predictor for predictor in read_trained(folder)}
    for name in names:
        if name not in trained:
            problem = f"no predictor {name} was trained; there are {', '.join(trained)}"
            raise InputError("params.yaml", problem, field="sim2real.learned")
    return [trained[name] for name in names]


def read_trained(folder: Path) -> Iterator[NamedPredictor]:
    """Yield all trained predictors of a folder, by name.

    Raises:
        InputError: there is none, or one is invalid.
    """
    paths = sorted(folder.glob(f"*/{DESCRIPTION}"))
    if not paths:
        raise InputError(folder, "has no trained predictor; run `dvc repro train_predictor`")
    for path in paths:
        described = read_description(path.parent)
        yield NamedPredictor(
            described.name,
            load_predictor(path.parent),
            described.network.kind,
            parameters=described.parameters,
            trained_on=tuple(described.sources),
            starts_from=described.starts_from,
        )
