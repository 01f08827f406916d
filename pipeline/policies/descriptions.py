"""The policies that parameters ask for."""

from collections.abc import Iterator

from rallygap.models.policy.random_streams import training_seed
from rallygap.models.policy.settings import HorizonsMs
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import TrainPolicySettings
from rallygap.pipeline.policies.storage import TrainedPolicy


def described_policies(settings: TrainPolicySettings, seed: int) -> Iterator[TrainedPolicy]:
    """Yield the policies to train; a repeat has the same seed in all simulators and horizons."""
    for name, group in settings.groups.items():
        for simulator in group.simulators:
            for horizons in group.horizons_ms:
                for repeat in range(group.repeats):
                    own = training_seed(seed, repeat)
                    yield described_policy(settings, name, simulator, horizons, own, repeat)


def described_policy(
    settings: TrainPolicySettings,
    group: str,
    simulator: str,
    horizons: HorizonsMs,
    seed: int,
    repeat: int,
) -> TrainedPolicy:
    """Describe a policy of a group to train; arguments as in ``TrainedPolicy``."""
    shared = settings.groups[group]
    return TrainedPolicy(
        group=group,
        simulator=simulator,
        effects=load_simulator(simulator).to_dict(),
        horizons=horizons,
        observation=shared.observation,
        goals=shared.goals,
        learning=shared.learning,
        seed=seed,
        repeat=repeat,
        reward=settings.reward,
    )
