"""The policies that parameters ask for."""

from collections.abc import Iterator, Mapping

from rallygap.models.policy.random_streams import training_seed
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import PolicyGroupSettings
from rallygap.pipeline.policies.storage import TrainedPolicy


def described_policies(
    groups: Mapping[str, PolicyGroupSettings], seed: int
) -> Iterator[TrainedPolicy]:
    """Yield the policies to train; a repeat has the same seed in all simulators and horizons."""
    for name, group in groups.items():
        for simulator in group.simulators:
            for horizons in group.horizons_ms:
                for repeat in range(group.repeats):
                    yield TrainedPolicy(
                        group=name,
                        simulator=simulator,
                        effects=load_simulator(simulator).to_dict(),
                        horizons=horizons,
                        observation=group.observation,
                        goals=group.goals,
                        learning=group.learning,
                        seed=training_seed(seed, repeat),
                        repeat=repeat,
                    )
