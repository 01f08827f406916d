"""Episodes from flights and contacts."""

import numpy as np
import pytest

from models.segmentation.contacts import Contact
from models.segmentation.cuts import Cuts
from models.segmentation.episodes import episodes

DOWN, UP, STRUCK = np.array([0.0, 4.0, -3.0]), np.array([0.0, 3.5, 2.8]), np.array([0.0, -6.0, 2.0])


def bounce(y, height=0.02):
    return Contact(0.0, np.array([0.0, y, height]), DOWN, UP, 0.0)


def stroke(y=1.5):
    return Contact(0.0, np.array([0.0, y, 0.3]), DOWN, STRUCK, 0.0)


def joined(*contacts, first="recording"):
    """Episodes of flights that begin with these contacts; ``None`` is a gap."""
    flights = np.arange(len(contacts) + 1)
    found = {number: contact for number, contact in enumerate(contacts, 1) if contact}
    unknown = np.full(len(flights), np.nan)
    cuts = Cuts(flights, np.full((len(flights), 3), np.nan), unknown == 0, unknown, found)
    return [(one.starts_with, one.flights, one.ends_with) for one in episodes(cuts, first)]


def test_stroke_ends_an_episode_and_begins_the_next():
    assert joined(bounce(0.8), stroke(), bounce(-0.8)) == [
        ("recording", [0, 1], "racket"),
        ("racket", [2, 3], "recording"),
    ]


def test_serve_bounces_on_both_sides():
    assert joined(stroke(-1.5), bounce(-0.9), bounce(0.8), stroke(1.5)) == [
        ("recording", [0], "racket"),
        ("racket", [1, 2, 3], "racket"),
        ("racket", [4], "recording"),
    ]


@pytest.mark.parametrize("last", [bounce(1.2), bounce(2.5, height=-0.74)])
def test_rally_ends_with_a_second_bounce_on_one_side_and_on_the_floor(last):
    assert joined(bounce(0.5), last, bounce(1.3)) == [("recording", [0, 1], "rally_end")]


def test_ball_is_played_again_after_a_rally():
    assert joined(bounce(0.5), bounce(1.2), stroke(), bounce(-0.5)) == [
        ("recording", [0, 1], "rally_end"),
        ("racket", [3, 4], "recording"),
    ]


def test_gap_ends_an_episode():
    assert joined(bounce(0.5), None, bounce(0.5)) == [
        ("recording", [0, 1], "gap"),
        ("gap", [2, 3], "recording"),
    ]


def test_what_begins_a_recording_is_taken_from_its_source():
    assert joined(bounce(0.5), first="launch") == [("launch", [0, 1], "recording")]


def test_recording_without_a_flight_has_no_episode():
    nothing = np.array([-1, -1])
    unknown = np.full(2, np.nan)
    cuts = Cuts(nothing, np.full((2, 3), np.nan), unknown == 0, unknown)
    assert list(episodes(cuts, "recording")) == []
