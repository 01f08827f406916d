"""Episodes from flights and contacts."""

import numpy as np
import pytest

from rallygap.models.segmentation.contacts import Contact
from rallygap.models.segmentation.cuts import Cuts
from rallygap.models.segmentation.episodes import episodes

DOWN, UP, STRUCK = np.array([0.0, 4.0, -3.0]), np.array([0.0, 3.5, 2.8]), np.array([0.0, -6.0, 2.0])


def bounce(y, height=0.02):
    return Contact(0.0, np.array([0.0, y, height]), DOWN, UP, 0.0)


def stroke(y=1.5):
    return Contact(0.0, np.array([0.0, y, 0.3]), DOWN, STRUCK, 0.0)


def joined(*contacts, first="recording"):
    """Episodes of flights that start with these contacts; ``None`` is a gap."""
    flights = np.arange(len(contacts) + 1)
    found = {number: contact for number, contact in enumerate(contacts, 1) if contact}
    unknown = np.full(len(flights), np.nan)
    cuts = Cuts(flights, np.full((len(flights), 3), np.nan), unknown == 0, unknown, found)
    return [(one.starts_with, one.flights, one.ends_with) for one in episodes(cuts, first)]


RALLY_END = [("recording", [0, 1], "rally_end")]
EPISODES = {
    "a stroke ends an episode": (
        [bounce(0.8), stroke(), bounce(-0.8)],
        [("recording", [0, 1], "racket"), ("racket", [2, 3], "recording")],
    ),
    "a serve bounces on both sides": (
        [stroke(-1.5), bounce(-0.9), bounce(0.8), stroke(1.5)],
        [
            ("recording", [0], "racket"),
            ("racket", [1, 2, 3], "racket"),
            ("racket", [4], "recording"),
        ],
    ),
    "second bounce on one side": ([bounce(0.5), bounce(1.2), bounce(1.3)], RALLY_END),
    "floor": ([bounce(0.5), bounce(2.5, height=-0.74), bounce(1.3)], RALLY_END),
    "a stroke after a rally": (
        [bounce(0.5), bounce(1.2), stroke(), bounce(-0.5)],
        [*RALLY_END, ("racket", [3, 4], "recording")],
    ),
    "a gap ends an episode": (
        [bounce(0.5), None, bounce(0.5)],
        [("recording", [0, 1], "gap"), ("gap", [2, 3], "recording")],
    ),
}


@pytest.mark.parametrize(("contacts", "expected"), EPISODES.values(), ids=EPISODES)
def test_contacts_and_gaps_separate_episodes(contacts, expected):
    assert joined(*contacts) == expected
    assert joined(*contacts, first="launch")[0] == ("launch", *expected[0][1:])


def test_recording_without_a_flight_has_no_episode():
    nothing = np.array([-1, -1])
    unknown = np.full(2, np.nan)
    cuts = Cuts(nothing, np.full((2, 3), np.nan), unknown == 0, unknown)
    assert list(episodes(cuts, "recording")) == []
