"""Rallies: many points at once, stroke by stroke, until each of them is decided."""

import numpy as np
from numpy.typing import NDArray

from models.arena import footwork, serves, strokes, umpire
from models.arena.aim import aimed, in_air
from models.arena.contacts import Touches, touches
from models.arena.event_log import Log
from models.arena.levels import Players
from models.arena.sides import TOWARDS, turned
from models.arena.truth import Truth

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

MOST_CONTACTS = 6  # that are followed of a stroke
LEAST_CLEARANCE, MORE_CLEARANCE = 0.01, 0.08  # m above the net that players aim at
SEEN_AFTER = (0.2, 0.8)  # s that a ball is seen after its point


class Rallies:
    """N points that are played at once; each row is one ball in play."""

    def __init__(
        self, truth: Truth, players: Players, servers: Integers, random: np.random.Generator
    ) -> None:
        """Set up points.

        Args:
            truth: the hall's physics.
            players: (2 N,) the near players of all points, then the far ones.
            servers: (N,) sides that serve.
            random: where all variety comes from.
        """
        count = len(servers)
        self.truth, self.players, self.random = truth, players, random
        self.log = Log.of(count)
        self.points = np.arange(count)
        self.side = servers.copy()
        self.struck = np.zeros(count)  # s, when the ball was struck last
        self.place = np.tile(footwork.READY, (count, 1))  # of the one who struck last, own frame
        self.other = self.place.copy()  # where the other one stood then, own frame

    def play(self) -> Log:
        """Play all points to their ends."""
        launches = self._serve()
        serve = True
        while len(self.points):
            launches = self._exchange(launches, serve)
            serve = False
        return self.log

    def _serve(self) -> Floats:
        ways, servers = TOWARDS[self.side], self._players(self.side)
        air = in_air(self.truth.simulator)
        palms, times, balls = serves.tossed(air, ways, self.random)
        launches = serves.served(self.truth.simulator, balls, ways, servers, self.random)
        self.log.note(self.points, np.zeros(len(self.points)), "launch", turned(palms, ways))
        self.struck, self.place = times, launches[:, :2]
        return self._struck(turned(launches, ways))

    def _exchange(self, launches: Floats, serve: bool) -> Floats:
        """Follow the balls, end points, and return the launches of those that go on."""
        flight = touches(self.truth, launches, MOST_CONTACTS, self.random)
        call = umpire.called(flight, TOWARDS[self.side], serve)
        meeting = self._meeting(flight, call)
        goes_on = call.good & meeting.reached
        self._end(flight, call, ~goes_on)
        rows = np.flatnonzero(goes_on)
        landed = flight.times[rows, call.landing[rows]]
        until = landed + meeting.times[rows]
        self.log.note_touches(self.points[rows], self.struck[rows], flight.take(rows), until)
        self._change_sides(rows, until)
        self.place = meeting.balls[rows, :2]
        return self._struck(self._replies(meeting.balls[rows], meeting.stretch[rows]))

    def _meeting(self, flight: Touches, call: umpire.Call) -> footwork.Meeting:
        """Return where the other side meets the balls (of faulty strokes: nowhere of interest)."""
        rows, receivers = np.arange(len(self.points)), 1 - self.side
        ways = TOWARDS[receivers]
        landed = np.where(call.good[:, None], flight.states[rows, call.landing], _DEAD)
        paths = self.truth.simulator.fly(landed, footwork.MOMENTS).states
        warned = np.where(call.good, flight.times[rows, call.landing], 0.0)
        lost, _ = umpire.after_landing(flight, call.landing)
        players = self._players(receivers)
        return footwork.met(turned(paths, ways), warned, lost - warned, self.other, players)

    def _replies(self, balls: Floats, stretch: Floats) -> Floats:
        """Return what the players whose turn it is make of their balls, in the hall's frame."""
        ways, players = TOWARDS[self.side], self._players(self.side)
        wish = strokes.intended(balls, stretch, players, self.random)
        start, spins, targets = _in_hall(balls, wish, ways)
        clearances = LEAST_CLEARANCE + MORE_CLEARANCE * self.random.random(len(balls))
        launches = aimed(self.truth.simulator, start, spins, targets, wish.times, clearances)
        own = strokes.executed(turned(launches, ways), balls, stretch, players, self.random)
        return turned(own, ways)

    def _struck(self, launches: Floats) -> Floats:
        self.log.note(self.points, self.struck, "racket", launches)
        self.log.strokes[self.points] += 1
        return launches

    def _end(self, flight: Touches, call: umpire.Call, ends: NDArray[np.bool_]) -> None:
        rows = np.flatnonzero(ends)
        flight, good = flight.take(rows), call.good[rows]
        time, how = umpire.lost_by(flight, call.landing[rows])
        end = np.where(good, time, call.decided[rows])
        gone = np.minimum(flight.gone, end + self.random.uniform(*SEEN_AFTER, len(rows)))
        points, starts, side = self.points[rows], self.struck[rows], self.side[rows]
        winner = np.where(good, side, 1 - side)
        ended_by = np.where(good, how, call.fault[rows])
        self.log.note_touches(points, starts, flight, gone)
        self.log.decide(points, winner, ended_by, starts + end, starts + gone)

    def _change_sides(self, rows: Integers, since: Floats) -> None:
        """Go on with some rows, in which the ball is struck some seconds after the last stroke."""
        self.points, self.side = self.points[rows], self.side[rows]
        walkers = self._players(self.side)
        self.other = footwork.returned(self.place[rows], since, walkers)
        self.struck, self.side = self.struck[rows] + since, 1 - self.side

    def _players(self, sides: Integers) -> Players:
        return self.players.take(self.points + sides * len(self.log.strokes))


# A ball at which nobody looks, in the place of those that were faulty.
_DEAD = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def _in_hall(balls: Floats, wish: strokes.Intention, ways: Floats) -> tuple[Floats, Floats, Floats]:
    """Return places, spins and targets in the hall's frame."""
    wanted = balls.copy()
    wanted[:, 6:] = wish.spins
    wanted = turned(wanted, ways)
    return wanted[:, :3], wanted[:, 6:], wish.targets * ways[:, None]
