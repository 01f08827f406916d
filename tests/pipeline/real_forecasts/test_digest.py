"""A digest of recordings notices all that may change in one of them."""

from dataclasses import fields, replace

import numpy as np
import pytest

from rallygap.models.predictors.windows import Episode
from rallygap.pipeline.io.episodes import MeasuredEpisode
from rallygap.pipeline.real_forecasts.digest import episodes_digest

TIMES = np.array([0.0, 0.1, 0.2])
PLACES = np.arange(9.0).reshape(3, 3)
SAMPLES = Episode(
    TIMES, PLACES, PLACES + 1, PLACES + 2, np.zeros(3, bool), np.zeros(3, int), np.array([0.1])
)
EPISODE = MeasuredEpisode(
    "lab/0/00", "lab/0", "lab", "test", True, SAMPLES, np.array([0.15]), np.array([0.16])
)


def other(value):
    """A value that differs."""
    if isinstance(value, str):
        return f"{value} again"
    return np.logical_not(value) if np.asarray(value).dtype == bool else -1 - value


@pytest.mark.parametrize("name", [one.name for one in fields(Episode)])
def test_samples(name):
    changed = replace(SAMPLES, **{name: other(getattr(SAMPLES, name))})
    assert episodes_digest([replace(EPISODE, episode=changed)]) != episodes_digest([EPISODE])


@pytest.mark.parametrize("name", [one.name for one in fields(EPISODE) if one.name != "episode"])
def test_origin_and_contacts(name):
    changed = replace(EPISODE, **{name: other(getattr(EPISODE, name))})
    assert episodes_digest([changed]) != episodes_digest([EPISODE])


def test_the_same_recordings_have_the_same_digest():
    again = replace(EPISODE, episode=replace(SAMPLES, times=TIMES.copy()))
    assert episodes_digest([again]) == episodes_digest([EPISODE])
    assert episodes_digest([EPISODE, EPISODE]) != episodes_digest([EPISODE])
