"""Trials for the tests: the nominal simulator, with and without errors of cameras and bounces."""

from dataclasses import replace
from functools import cache

import numpy as np

from experiments.exam.simulate.recordings import simulate_trial
from experiments.exam.simulate.trial import CAMERAS, Trial
from rallygap.models.arena.bounce_scatter import BounceScatter
from rallygap.models.arena.cameras import SlowError
from rallygap.models.audit.launches import launches
from rallygap.models.ball.simulators import shipped

NOMINAL = shipped("literature")
NO_SCATTER = BounceScatter(restitution=0.0, friction=0.0)
PERFECT = replace(
    CAMERAS,
    position_noise=0.0,
    spin_noise=0.0,
    dropouts=0.0,
    outliers=0.0,
    slow_error=SlowError(share=0.0, time=0.05),
)


def trial(**settings):
    return Trial("trial", NOMINAL, **settings)


def ideal(**settings):
    return trial(cameras=PERFECT, scatter=NO_SCATTER, **settings)


def drawn(shots=100, directions=2, seed=0):
    return launches(NOMINAL, shots, directions, np.random.default_rng(seed))


@cache
def recorded(effect=None, parameter="", value=0.0, **settings):
    causes = {effect: {parameter: value}} if effect else {}
    # Equal labels in successive rows count as one.
    cameras = replace(PERFECT, spin_noise=1e-6)
    settings = {"cameras": cameras, "scatter": NO_SCATTER, **settings}
    return simulate_trial(trial(shots=24, seed=1002, causes=causes, **settings))[0]
