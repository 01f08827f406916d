"""Streams: what is random in a training, each use with numbers of its own that follow from a seed.

So nothing that a policy is judged on has been seen in training, nor do balls that one is watched on
tell anything of those that it is judged by.
"""

import numpy as np

_LEG, _WATCHED, _UNSEEN = 0, 1, 2


def leg_seed(seed: int, leg: int) -> int:
    """Return the seed of a leg: of its first weights, balls, batches and actions."""
    return int(np.random.SeedSequence([seed, _LEG, leg]).generate_state(1)[0])


def watched_balls(seed: int) -> np.random.Generator:
    """Return the source of the balls on which a training is watched."""
    return np.random.default_rng([seed, _WATCHED])


def unseen_balls(seed: int) -> np.random.Generator:
    """Return the source of the balls on which a trained policy is judged."""
    return np.random.default_rng([seed, _UNSEEN])
