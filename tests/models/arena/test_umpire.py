"""The umpire: decisions from the contacts of a ball."""

import numpy as np
import pytest

from rallygap.models.arena.contacts import FLOOR_SURFACE, ContactSequence
from rallygap.models.arena.umpire import after_landing, judge_strokes
from rallygap.models.ball.contact_laws import NET, TABLE

OWN, OTHER = (TABLE, -0.8), (TABLE, 0.8)
CORD, FLOOR = (NET, 0.0), (FLOOR_SURFACE, 2.0)


def flight(*met, most=4):
    """Return the contacts of one ball struck towards +y, a tenth of a second apart."""
    states = np.full((1, most, 9), np.nan)
    times, surfaces = np.full((1, most), np.inf), np.zeros((1, most), dtype=np.int64)
    for k, (surface, y) in enumerate(met):
        states[0, k] = [0, y, 0.02, 0, 0, 0, 0, 0, 0]
        times[0, k], surfaces[0, k] = 0.1 * (k + 1), surface
    return ContactSequence(times, surfaces, states, np.array([0.1 * len(met) + 0.5]))


@pytest.mark.parametrize(
    ("met", "serve", "fault"),
    [
        ([OTHER, FLOOR], False, None),
        ([CORD, OTHER], False, None),
        ([OWN, OTHER], False, "out"),
        ([OWN, CORD], False, "out"),
        ([FLOOR], False, "out"),
        ([], False, "out"),
        ([CORD, OWN], False, "net"),
        ([OWN, OTHER], True, None),
        ([OWN, CORD, OTHER], True, None),
        ([OTHER, FLOOR], True, "out"),
        ([OWN, OWN, OTHER], True, "out"),
        ([CORD, OTHER], True, "net"),
    ],
)
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_stroke_is_good_if_it_lands_as_the_rules_ask_and_a_fault_has_a_name(
    met, serve, fault, direction
):
    seen = flight(*met)
    seen.states[..., 1] *= direction
    ruling = judge_strokes(seen, np.array([direction]), serve)
    assert (None if ruling.good[0] else ruling.fault[0]) == fault


@pytest.mark.parametrize("then", [OTHER, FLOOR])
def test_a_ball_that_nobody_returns_is_lost_at_its_next_contact(then):
    end, surface = after_landing(flight(OTHER, then), np.array([0]))
    assert surface[0] == then[0]
    assert end[0] == pytest.approx(0.2)
