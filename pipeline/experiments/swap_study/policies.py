"""The policies of the study: those of a profile, and the same trained in the amended simulator."""

from pathlib import Path

from rallygap.models.ball.simulator import Simulator
from rallygap.pipeline.evaluation.predictors import ARENA
from rallygap.pipeline.io.amended_simulators import amended_by
from rallygap.pipeline.params import Params
from rallygap.pipeline.policies.storage import described_policies
from rallygap.pipeline.policies.training import TrainingJob, TrainingResult, train_policies
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.transfer.retraining import in_simulator

RETRAINED_KIND = "intercept"  # what the policies observe that are trained again


def trained_policies(root: Path, params: Params, folder: Path) -> list[TrainingResult]:
    """Train the policies of the profile, and the same in the amended simulator."""
    described = list(described_policies(params.train_policy, params.seed))
    amended = amended_simulator(root, params)
    again = [
        in_simulator(one, ARENA, amended) for one in described if one.observation == RETRAINED_KIND
    ]
    return train_policies([TrainingJob(one, folder / one.name) for one in (*described, *again)])


def amended_simulator(root: Path, params: Params) -> Simulator:
    """Return the simulator of the policies as close_gap has amended it from shots of the arena.

    Raises:
        InputError: it has not.
    """
    nominal = params.sim2real.simulator
    found = amended_by(root / "artifacts" / "close_gap", ARENA, nominal)
    if found is None:
        problem = f"close_gap has not amended {nominal} from shots of the arena"
        raise InputError("params.yaml", problem, field="close_gap.name")
    return found
