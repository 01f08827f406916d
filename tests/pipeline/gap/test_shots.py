"""Shots: which episodes they are, and which of them serve for training."""

import numpy as np
import pytest

from rallygap.models.predictors.windows import Episode
from rallygap.pipeline.gap.shots import net_contacts, source_shots
from rallygap.pipeline.io.episodes import MeasuredEpisode


def episode(samples=20, touched=(), nets=(), bounces=(), unbroken=True):
    """An episode at 100 Hz whose ball bounces, and touches other things at some times."""
    times, places = 0.01 * np.arange(samples), np.zeros((samples, 3))
    arcs = np.zeros(samples, dtype=int)
    whole = Episode(times, places, places, places, times < 0, arcs, np.array(bounces))
    contacts = np.array([*touched, *nets]), np.array(nets)
    return MeasuredEpisode("lab/0/00", "lab/0", "lab", "test", unbroken, whole, *contacts)


@pytest.mark.parametrize(
    ("one", "left_out"),
    [
        (episode(), {}),
        (episode(touched=[0.155], bounces=[0.095]), {}),
        (episode(nets=[0.095]), {"too short": 1}),
        (episode(samples=12), {"too short": 1}),
        (episode(unbroken=False), {"broken": 1}),
    ],
)
def test_a_shot_is_whole_and_long_enough(one, left_out):
    found = source_shots([one])
    assert (len(found.members), found.left_out) == (not left_out, left_out)


def test_a_shot_ends_where_the_ball_touches_something_else_than_the_table():
    touching = episode(bounces=[0.055], touched=[0.185], nets=[0.155])
    touched, bounced = source_shots([touching, episode(bounces=[0.055])]).members
    assert touched.episode.times[-1] == pytest.approx(0.15)
    assert len(bounced.episode.times) == 20


def test_arcs_about_the_net_end_at_the_contacts_next_to_it():
    found = net_contacts([episode(samples=40, bounces=[0.055, 0.305], nets=[0.155])])
    assert len(found) == 1
    assert found.before.times[0] == pytest.approx(np.arange(0.06, 0.155, 0.01))
    assert found.after.times[0] == pytest.approx(np.arange(0.16, 0.305, 0.01))


def test_contacts_with_short_arcs_or_other_things_do_not_serve():
    others = [
        episode(samples=40),
        episode(samples=40, touched=[0.155]),
        episode(samples=40, nets=[0.155], unbroken=False),
        episode(samples=40, bounces=[0.125], nets=[0.155]),
        episode(samples=18, nets=[0.155]),
    ]
    assert len(net_contacts(others)) == 0
