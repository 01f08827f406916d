"""What is random follows from the seed, and no two uses of it share their numbers."""

import numpy as np

from models.policy.random_streams import leg_seed, unseen_balls, watched_balls


def test_the_seed_decides():
    assert leg_seed(3, 1) == leg_seed(3, 1)
    for source in (watched_balls, unseen_balls):
        np.testing.assert_array_equal(source(3).random(4), source(3).random(4))
        assert not np.isclose(source(3).random(4), source(4).random(4)).any()


def test_training_watching_and_judging_see_different_balls():
    sources = [np.random.default_rng(leg_seed(3, leg)) for leg in range(4)]
    sources += [watched_balls(3), unseen_balls(3), np.random.default_rng(3)]

    first = [source.random() for source in sources]

    assert len(set(first)) == len(sources)
