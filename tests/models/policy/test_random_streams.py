"""What is random follows from the seed, and no two uses of it share their numbers."""

import numpy as np

from rallygap.models.policy.random_streams import (
    evaluation_stream,
    iteration_seed,
    validation_stream,
)


def test_training_watching_and_judging_see_different_balls():
    sources = [np.random.default_rng(iteration_seed(3, iteration)) for iteration in range(4)]
    sources += [validation_stream(3), evaluation_stream(3), np.random.default_rng(3)]

    first = [source.random() for source in sources]

    assert len(set(first)) == len(sources)
