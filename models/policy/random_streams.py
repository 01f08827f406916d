"""Independent random streams of a training, all derived from its seed.

Training, validation and test balls come from different streams, so none is seen in another's use.
"""

import numpy as np

_ITERATION, _VALIDATION, _EVALUATION = 0, 1, 2


def training_seed(seed: int, repeat: int) -> int:
    """Return the seed of a training by that of all and the number of the repeat."""
    return int(np.random.SeedSequence([seed, repeat]).generate_state(1)[0])


def iteration_seed(seed: int, iteration: int) -> int:
    """Return the seed of an iteration: of initial weights, balls, batches and actions."""
    return int(np.random.SeedSequence([seed, _ITERATION, iteration]).generate_state(1)[0])


def validation_stream(seed: int) -> np.random.Generator:
    """Return the source of the balls that draw the learning curve."""
    return np.random.default_rng([seed, _VALIDATION])


def evaluation_stream(seed: int) -> np.random.Generator:
    """Return the source of the balls on which a trained policy is tested."""
    return np.random.default_rng([seed, _EVALUATION])
