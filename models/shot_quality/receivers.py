"""Simulated points against receivers whose reach or errors differ from a professional's."""

from dataclasses import dataclass, replace

import numpy as np

from rallygap.models.arena.levels import Players
from rallygap.models.arena.rallies import Rallies
from rallygap.models.arena.truth import Truth
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.outcome import judge
from rallygap.models.shot_quality.shots import Shots, clearance, landings, shot_features

LEVEL = "pro"
NEAR = 0  # the side of the unchanged player, whose shots count
ERRORS = ("angle_error", "speed_error", "spin_error")


@dataclass(frozen=True)
class Receiver:
    """A professional with some traits changed, who has to return the shots.

    Attributes:
        name: for reports.
        reach: factor on how far they reach.
        error: factor on the errors of their strokes.
        draw: of the points; receivers of one draw play the same opponents.
    """

    name: str
    reach: float = 1.0
    error: float = 1.0
    draw: int = 0


RECEIVERS = (
    Receiver("nominal"),
    Receiver("nominal_repeat", draw=1),
    Receiver("less_reach", reach=2 / 3),
    Receiver("more_reach", reach=4 / 3),
    Receiver("less_error", error=2 / 3),
    Receiver("more_error", error=4 / 3),
)


def play_against(
    receiver: Receiver, truth: Truth, points: int, random: np.random.Generator
) -> Shots:
    """Simulate points between professionals and a receiver; each point counts as a match.

    Args:
        receiver: plays at y > 0.
        truth: the arena's physics.
        points: how many.
        random: of all draws.

    Returns:
        The good returns of the professionals at y < 0, without serves.
    """
    players = Players.draw(LEVEL, 2 * points, random)
    far = np.arange(2 * points) >= points  # the near players of all points come first
    error = np.where(far, receiver.error, 1.0)
    errors = {name: getattr(players, name) * error for name in ERRORS}
    players = replace(players, reach=players.reach * np.where(far, receiver.reach, 1.0), **errors)
    log = Rallies(truth, players, random.integers(2, size=points), random).play()
    rallies, contacts = log.contacts()
    near = (contacts.kinds == "racket") & (contacts.states[:, 4] > 0)  # struck towards +y
    strokes, rallies = contacts.states[near], rallies[near]
    outcome = judge(truth.simulator, strokes, Goals(np.zeros((len(strokes), 2))))
    good = outcome.returned
    last = np.append(rallies[1:] != rallies[:-1], True)
    point = log.winner[rallies] == NEAR
    features = shot_features(
        landings(truth.simulator, strokes[good]), clearance(outcome.net_height[good])
    )
    return Shots(features, (point & last)[good], point[good], rallies[good])
