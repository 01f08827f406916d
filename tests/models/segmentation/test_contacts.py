"""Where paths closest_approach, and what the ball met."""

import numpy as np
import pytest

from rallygap.models.segmentation.contacts import Contact, closest_approach, extrapolated


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
