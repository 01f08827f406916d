"""The study of a sweep: Optuna's record of all trials."""

import warnings

import optuna
from optuna.distributions import BaseDistribution
from optuna.exceptions import ExperimentalWarning
from optuna.pruners import MedianPruner
from optuna.samplers import BaseSampler, TPESampler
from optuna.trial import FrozenTrial, TrialState

from pipeline.sweeps.plan import Plan
from pipeline.sweeps.storage import alone, storage

TRIED = (TrialState.COMPLETE, TrialState.PRUNED)

warnings.filterwarnings("ignore", category=ExperimentalWarning)
optuna.logging.set_verbosity(optuna.logging.ERROR)


def create_study(plan: Plan, url: str | None) -> optuna.Study:
    """Make the study, if it is not there yet; its first trial are the parameters as they are."""
    with alone(url):
        study = optuna.create_study(
            storage=storage(plan, url),
            study_name=plan.study,
            direction=plan.settings.direction,
            load_if_exists=True,
        )
        defaults = plan.defaults()
        if defaults is not None and not study.trials:
            study.enqueue_trial(defaults)
    return study


def load_study(plan: Plan, name: str, url: str | None) -> optuna.Study:
    """Open a study that was made, to add trials to it."""
    pruning = plan.settings.pruning
    return optuna.load_study(
        study_name=name,
        storage=storage(plan, url),
        sampler=NumberedSampler(plan.params["seed"]),
        pruner=MedianPruner(pruning.first_trials, pruning.first_steps + 1),  # steps count from 1
    )


def tried(study: optuna.Study) -> int:
    """How many trials have come to an end of their own."""
    return len(study.get_trials(deepcopy=False, states=TRIED))


def running(study: optuna.Study) -> list[FrozenTrial]:
    """The trials that are under way, or were when their worker died."""
    return study.get_trials(deepcopy=True, states=(TrialState.RUNNING,))


class NumberedSampler(BaseSampler):
    """A tree-structured Parzen estimator whose draws follow from the seed and the trial's number.

    So workers never draw alike, and a study that goes on later goes on as if it had not stopped.
    """

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self.estimator = TPESampler(seed=seed)

    def before_trial(self, study: optuna.Study, trial: FrozenTrial) -> None:
        """Begin the draws of a trial."""
        self.estimator = TPESampler(seed=(self.seed + 1_000_003 * trial.number) % 2**32)

    def infer_relative_search_space(
        self, study: optuna.Study, trial: FrozenTrial
    ) -> dict[str, BaseDistribution]:
        """Ask the estimator."""
        return self.estimator.infer_relative_search_space(study, trial)

    def sample_relative(
        self, study: optuna.Study, trial: FrozenTrial, search_space: dict[str, BaseDistribution]
    ) -> dict[str, object]:
        """Ask the estimator."""
        return self.estimator.sample_relative(study, trial, search_space)

    def sample_independent(
        self,
        study: optuna.Study,
        trial: FrozenTrial,
        param_name: str,
        param_distribution: BaseDistribution,
    ) -> object:
        """Ask the estimator."""
        return self.estimator.sample_independent(study, trial, param_name, param_distribution)
