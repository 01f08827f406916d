"""The predictors that are evaluated: physics by parameter or amended, the oracle, the trained."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import torch

from models.predictors.physics import PhysicsPredictor
from models.predictors.protocol import Predictor
from pipeline.io.amended_simulators import AMENDED, read_amended
from pipeline.io.ground_truth import read_truth
from pipeline.io.simulators import load_simulator
from pipeline.params import EvaluatePredictorSettings
from pipeline.predictors.storage import DESCRIPTION, load_predictor, read_description
from pipeline.runtime.errors import InputError

ORACLE, ARENA = "oracle", "arena"


@dataclass(frozen=True)
class Contender:
    """A predictor with its name and what it knows.

    Attributes:
        name: under which reports list it.
        predictor: forecasts.
        kind: ``physics``, ``amended``, ``oracle`` or the kind of network.
        simulator: what flies its ball, if anything does.
        parameters: how many numbers were trained, if any were.
        trained_on: the sets of measured balls that it learned from last.
        starts_from: the predictor that learned before, if any.
    """

    name: str
    predictor: Predictor
    kind: str
    simulator: str | None = None
    parameters: int | None = None
    trained_on: tuple[str, ...] = ()
    starts_from: str | None = None

    def forecasts(self, source: str) -> bool:
        """Return whether it is evaluated on a set: some know the physics of one alone."""
        known = {ORACLE: (ARENA,), AMENDED: self.trained_on}
        return self.kind not in known or source in known[self.kind]


@contextmanager
def one_thread() -> Iterator[None]:
    """Let torch work on one thread.

    Its results then do not depend on the number of cores; and threads that share so little work
    wait for one another, beside other work up to 60 times longer than one thread takes alone.
    """
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)


def read_contenders(artifacts: Path, settings: EvaluatePredictorSettings) -> list[Contender]:
    """Return all predictors that there are.

    Args:
        artifacts: the folder of all stages' artefacts.
        settings: name those that need no training.

    Raises:
        InputError: a simulator, a trained predictor or the truth is missing or broken.
    """
    return [
        *_physics(settings),
        *_amended(artifacts / "close_gap"),
        *_oracle(artifacts / "ingest" / "truth.json"),
        *read_trained(artifacts / "train_predictor"),
    ]


def _physics(settings: EvaluatePredictorSettings) -> Iterator[Contender]:
    for name, described in settings.predictors.items():
        predictor = PhysicsPredictor(load_simulator(described.simulator))
        yield Contender(name, predictor, described.kind, simulator=described.simulator)


def _amended(folder: Path) -> Iterator[Contender]:
    for one in read_amended(folder):
        yield Contender(
            f"{AMENDED}_{one.begun}",
            PhysicsPredictor(one.simulator),
            AMENDED,
            simulator=f"{one.begun}, amended",
            trained_on=(one.source,),
        )


def _oracle(path: Path) -> Iterator[Contender]:
    truth = read_truth(path)
    if truth is not None:
        predictor = PhysicsPredictor(truth.simulator)
        yield Contender(ORACLE, predictor, ORACLE, simulator="the arena's truth")


def read_learned(folder: Path, names: Sequence[str]) -> list[Contender]:
    """Return the trained predictors of a folder that ``sim2real.learned`` names.

    Raises:
        InputError: one is not there, or is broken.
    """
    trained = {one.name: one for one in read_trained(folder)}
    for name in names:
        if name not in trained:
            problem = f"no predictor {name} was trained; there are {', '.join(trained)}"
            raise InputError("params.yaml", problem, field="sim2real.learned")
    return [trained[name] for name in names]


def read_trained(folder: Path) -> Iterator[Contender]:
    """Yield all trained predictors of a folder, by name.

    Raises:
        InputError: there is none, or one is broken.
    """
    paths = sorted(folder.glob(f"*/{DESCRIPTION}"))
    if not paths:
        raise InputError(folder, "has no trained predictor; run `dvc repro train_predictor`")
    for path in paths:
        described = read_description(path.parent)
        yield Contender(
            described.name,
            load_predictor(path.parent),
            described.network.kind,
            parameters=described.parameters,
            trained_on=tuple(described.sources),
            starts_from=described.starts_from,
        )
