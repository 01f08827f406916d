"""Where paths meet, what the ball met there, and the episodes in between."""

import numpy as np
import pytest

from rallygap.models.segmentation.contacts import Contact, closest_approach, extrapolated
from rallygap.models.segmentation.cuts import Cuts
from rallygap.models.segmentation.episodes import episodes


@pytest.mark.parametrize("time", [-0.004, 0.0, 0.0037])
def test_closest_approach_is_the_constructed_contact(time):
    down = np.array([[0.1, 0.8, 0.02], [0.5, 4.0, -3.0], [0.0, 0.0, -9.81]])
    up = np.array([[0.1, 0.8, 0.02], [0.4, 3.5, 2.8], [0.0, 0.0, -9.81]])
    ends = (extrapolated(down, -0.010), time - 0.010), (extrapolated(up, 0.012), time + 0.012)
    met = closest_approach(*ends, time - 0.010, time + 0.012)
    assert met.time == pytest.approx(time, abs=1e-5)
    np.testing.assert_allclose(met.position, down[0], atol=1e-4)
    assert met.distance < 1e-4
    assert met.speed_change == pytest.approx(np.linalg.norm(up[1] - down[1]), rel=1e-2)


def test_closest_approach_stays_inside_its_bounds():
    path = np.array([[0.0, 0.0, 0.3], [0.0, 4.0, 0.0], [0.0, 0.0, -9.81]])
    other = np.add(path, [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    assert closest_approach((path, 0.0), (other, 0.1), 0.0, 0.1).time == 0.0


@pytest.mark.parametrize(
    ("before", "after", "position", "kind"),
    [
        ([0.5, 5.0, -3.0], [0.4, 4.2, 2.8], [0, 0.8, 0.02], "table"),
        ([0.5, 5.0, -3.0], [0.4, 4.2, 2.8], [0, 0.8, -0.01], "table"),  # may be off by 3 cm
        ([0.5, 5.0, -3.0], [0.4, 4.2, 2.8], [0, 0.8, 0.05], "table"),
        ([0.5, 2.0, -5.0], [0.4, 1.2, 4.0], [0, 0.8, -0.74], "floor"),
        ([0.5, 5.0, -3.0], [0.4, 4.2, 2.8], [0, 0.8, 0.40], "unknown"),
        ([0.5, 5.0, -3.0], [0.2, -7.0, 2.0], [0, 0.8, 0.30], "racket"),
        ([0.5, 5.0, -3.0], [0.2, -7.0, 2.0], [0, 0.8, 0.02], "racket"),  # no table turns a ball
        ([0.0, 0.0, -2.0], [0.0, 6.0, -1.0], [0, 0.8, 0.30], "racket"),  # a serve
        ([0.5, 8.0, -1.0], [0.4, 0.3, -0.5], [0, 0.8, 0.30], "unknown"),  # something soft
        ([0.0, 8.0, 0.0], [0.3, -1.5, 0.0], [0, 0.02, 0.1], "net"),  # it falls back
    ],
)
@pytest.mark.parametrize("mirror", [[1, 1, 1], [-1, 1, 1], [1, -1, 1]])
def test_kind_of_contact_is_that_of_its_reflection(before, after, position, kind, mirror):
    before, after, position = (np.multiply(part, mirror) for part in (before, after, position))
    assert Contact(0.0, position, before, after, 0.0).kind == kind


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
