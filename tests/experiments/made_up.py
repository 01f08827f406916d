"""Made-up shots and verdicts for known answers, and parameters of small arenas."""

import numpy as np

from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.verdict import Cause
from tests.models.predictors.small_training import BRIEF
from tests.pipeline.measured_shots import params
from tests.pipeline.verdicts import verdict

TIMES = 0.01 * np.arange(20)


def few_balls(networks, training=BRIEF):
    """Parameters of an arena of few balls, from which networks are trained."""
    plain = params()
    few = plain.ingest.arena.model_copy(update={"game_episodes": 40, "cannon_shots": 40})
    changes = {"networks": networks, "training": training}
    return params(
        ingest=plain.ingest.model_copy(update={"arena": few}),
        train_predictor=plain.train_predictor.model_copy(update=changes),
    )


def shots(recordings=6, each=2):
    """Shots with different paths, some of the same recording."""
    count = recordings * each
    random = np.random.default_rng(0)
    starts = random.uniform([-0.7, -1.3, 0.1], [0.7, 1.3, 0.6], (count, 3))
    velocities = random.normal(0.0, 3.0, (count, 3))
    return Shots.from_arrays(
        [TIMES] * count,
        [start + np.outer(TIMES, v) for start, v in zip(starts, velocities, strict=True)],
        [random.normal(0.0, 100.0, (1, 3)) for _ in range(count)],
        [TIMES[:1]] * count,
        groups=[f"lab/{k // each}" for k in range(count)],
    )


def cause(identity, estimate, nominal, margin=0.01, role="leading", possible=()):
    """A made-up cause with an interval of ``estimate`` plus or minus ``margin``."""
    return Cause(
        identity=identity,
        role=role,
        kind="wrong_value",
        unit=Hypothesis.from_identity(identity).declaration.unit,
        nominal=nominal,
        estimate=estimate,
        interval=(estimate - margin, estimate + margin),
        p_value=1e-4,
        gap_share=0.5,
        possible=(identity, *possible),
    )


def found(*causes):
    """A verdict with these causes."""
    return verdict("named" if causes else "no_gap", causes)
