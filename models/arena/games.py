"""Recordings of games: a few points of a match between the same two players."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from rallygap.models.arena.cameras import Cameras
from rallygap.models.arena.levels import Players
from rallygap.models.arena.rallies import EventLog, Rallies
from rallygap.models.arena.recording import ArenaRecording, Point, TrueContacts
from rallygap.models.arena.sides import SIDES
from rallygap.models.arena.truth import Truth
from rallygap.models.arena.truth_path import TrackedBall, observe
from rallygap.models.ball.types import Floats

POINTS = 2  # per recording
SERVES = 2  # in a row (ITTF Law 2.13.3)
PAUSE = (0.7, 1.5)  # s without a ball before a point


def games(
    truth: Truth, cameras: Cameras, level: str, matches: range, random: np.random.Generator
) -> Iterator[ArenaRecording]:
    """Simulate and measure a few points of each match between two players of a level."""
    count = len(matches)
    first = random.integers(2 * SERVES, size=count)  # the server's first point is random
    servers = ((first[:, None] + np.arange(POINTS)) // SERVES % 2).ravel()
    players = Players.draw(level, 2 * count, random)
    near = np.repeat(np.arange(count), POINTS)
    log = Rallies(truth, players.take(np.append(near, count + near)), servers, random).play()
    pauses = random.uniform(*PAUSE, (count, POINTS))
    last_visible = log.last_visible.reshape(pauses.shape)
    # When each point starts on the clock of its recording.
    starts = np.cumsum(pauses, axis=1) + np.cumsum(last_visible, axis=1) - last_visible
    starts = starts.ravel()
    balls = _balls(log, starts)
    samples = list(observe(truth, cameras, balls, random))
    points = [
        Point(
            start=float(starts[number]),
            end=float(starts[number] + log.end[number]),
            server=SIDES[servers[number]],
            winner=SIDES[log.winner[number]],
            ended_by=str(log.ended_by[number]),
            strokes=int(log.strokes[number]),
        )
        for number in range(len(balls))
    ]
    for index, match in enumerate(matches):
        rows = slice(index * POINTS, (index + 1) * POINTS)
        times, positions, spins = map(np.concatenate, zip(*samples[rows], strict=True))
        contacts = TrueContacts.joined(ball.contacts for ball in balls[rows])
        name = f"{level}/{match:04d}"
        yield ArenaRecording(name, times, positions, spins, contacts, tuple(points[rows]))


def _balls(log: EventLog, starts: Floats) -> list[TrackedBall]:
    points, contacts = log.contacts()
    contacts = contacts._replace(times=starts[points] + contacts.times)
    borders = np.searchsorted(points, np.arange(len(starts) + 1))
    return [
        TrackedBall(contacts.take(slice(*rows)), end)
        for rows, end in zip(pairwise(borders), starts + log.last_visible, strict=True)
    ]
