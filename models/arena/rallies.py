"""Simulation of many points at once, stroke by stroke, until each is decided, and their log."""

import numpy as np

from rallygap.models.arena import player_motion, serves, strokes, umpire
from rallygap.models.arena.contacts import KINDS, ContactSequence, follow_contacts
from rallygap.models.arena.levels import Players
from rallygap.models.arena.recording import TrueContacts
from rallygap.models.arena.sides import DIRECTIONS, switch_frame
from rallygap.models.arena.truth import Truth
from rallygap.models.ball.contact_laws import TABLE
from rallygap.models.ball.types import Bools, Floats, Integers

MAX_CONTACTS = 6  # simulated per stroke
MIN_CLEARANCE, CLEARANCE_RANGE = 0.01, 0.08  # m above the net that players aim at
VISIBLE_AFTER = (0.2, 0.8)  # s that a ball is recorded after the end of its point
FILLER = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])  # state of faulty balls


class EventLog:
    """Contacts and outcomes of N points, in any order.

    Attributes:
        strokes: (N,) racket contacts.
        winner: (N,) index of the side.
        ended_by: (N,) as in ``recording.Point``.
        end: (N,) s after the launch.
        last_visible: (N,) s after the launch of the last sample.
    """

    def __init__(self, count: int) -> None:
        self.strokes, self.winner = np.zeros((2, count), dtype=np.int64)
        self.end, self.last_visible = np.zeros((2, count))
        self.ended_by = np.full(count, "", dtype="<U13")
        self._points: list[Integers] = []
        self._contacts: list[TrueContacts] = []

    def add(self, points: Integers, times: Floats, kind: str, states: Floats) -> None:
        """Add one contact to each of some points."""
        self._points.append(points)
        kinds = np.full(len(points), kind, dtype="<U6")
        self._contacts.append(TrueContacts(times, kinds, states))

    def add_contacts(
        self, points: Integers, starts: Floats, flight: ContactSequence, until: Floats
    ) -> None:
        """Add the contacts up to a time ``until`` after the strokes at ``starts``."""
        for k in range(flight.times.shape[1]):
            for surface, kind in KINDS.items():
                noted = (flight.surfaces[:, k] == surface) & (flight.times[:, k] < until)
                times = (starts + flight.times[:, k])[noted]
                self.add(points[noted], times, kind, flight.states[noted, k])

    def contacts(self) -> tuple[Integers, TrueContacts]:
        """Return the point of each contact (n,) and the contacts, by point and time."""
        points, contacts = np.concatenate(self._points), TrueContacts.joined(self._contacts)
        order = np.lexsort([contacts.times, points])
        return points[order], contacts.take(order)


class Rallies:
    """N points played at once; each row is one ball in play."""

    def __init__(
        self, truth: Truth, players: Players, servers: Integers, random: np.random.Generator
    ) -> None:
        """Set up points; ``players`` (2 N,) are the near ones of all points, then the far ones."""
        count = len(servers)
        self.truth, self.players, self.random = truth, players, random
        self.log = EventLog(count)
        self.points = np.arange(count)
        self.side = servers.copy()
        self.struck = np.zeros(count)  # s, time of the last stroke
        # Positions in the own frame, of the last striker and of the receiver then.
        self.place = np.tile(player_motion.READY, (count, 1))
        self.other = self.place.copy()

    def play(self) -> EventLog:
        """Play all points to their ends."""
        launches = self._exchange(self._serve(), serve=True)
        while len(self.points):
            launches = self._exchange(launches, serve=False)
        return self.log

    def _serve(self) -> Floats:
        directions, servers = DIRECTIONS[self.side], self._players(self.side)
        air = self.truth.simulator.without_surfaces()
        palms, times, balls = serves.toss(air, directions, self.random)
        launches = serves.plan_serves(self.truth.simulator, balls, directions, servers, self.random)
        self.log.add(
            self.points, np.zeros(len(self.points)), "launch", switch_frame(palms, directions)
        )
        self.struck, self.place = times, launches[:, :2]
        return self._struck(switch_frame(launches, directions))

    def _exchange(self, launches: Floats, serve: bool) -> Floats:
        """Follow the balls, end points, and return the launches of those that go on."""
        flight = follow_contacts(self.truth, launches, MAX_CONTACTS, self.random)
        ruling = umpire.judge_strokes(flight, DIRECTIONS[self.side], serve)
        interception = self._interception(flight, ruling)
        goes_on = ruling.good & interception.reached
        self._end(flight, ruling, ~goes_on)
        rows = np.flatnonzero(goes_on)
        landed = flight.times[rows, ruling.landing[rows]]
        until = landed + interception.times[rows]
        self.log.add_contacts(self.points[rows], self.struck[rows], flight.take(rows), until)
        # Balls that go on are struck by the other side; the last striker walks back.
        self.points, self.side = self.points[rows], self.side[rows]
        self.other = player_motion.recover(self.place[rows], until, self._players(self.side))
        self.struck, self.side = self.struck[rows] + until, 1 - self.side
        self.place = interception.balls[rows, :2]
        return self._struck(self._replies(interception.balls[rows], interception.stretch[rows]))

    def _interception(
        self, flight: ContactSequence, ruling: umpire.Ruling
    ) -> player_motion.Interception:
        """Return where the receivers intercept the balls; meaningless for faulty strokes."""
        rows, receivers = np.arange(len(self.points)), 1 - self.side
        directions = DIRECTIONS[receivers]
        landed = np.where(ruling.good[:, None], flight.states[rows, ruling.landing], FILLER)
        paths = self.truth.simulator.fly(landed, player_motion.CONTACT_TIMES).states
        lead_time = np.where(ruling.good, flight.times[rows, ruling.landing], 0.0)
        lost, _ = umpire.after_landing(flight, ruling.landing)
        players = self._players(receivers)
        return player_motion.intercept(
            switch_frame(paths, directions), lead_time, lost - lead_time, self.other, players
        )

    def _replies(self, balls: Floats, stretch: Floats) -> Floats:
        """Return the strokes of the players whose turn it is, in the table frame."""
        directions, players = DIRECTIONS[self.side], self._players(self.side)
        targets, spins, times = strokes.plan_strokes(balls, stretch, players, self.random)
        wanted = balls.copy()
        wanted[:, 6:] = spins
        wanted = switch_frame(wanted, directions)
        clearances = MIN_CLEARANCE + CLEARANCE_RANGE * self.random.random(len(balls))
        targets = targets * directions[:, None]
        launches = strokes.aim_launches(
            self.truth.simulator, wanted[:, :3], wanted[:, 6:], targets, times, clearances
        )
        executed = strokes.execute_strokes(
            switch_frame(launches, directions), balls, stretch, players, self.random
        )
        return switch_frame(executed, directions)

    def _struck(self, launches: Floats) -> Floats:
        self.log.add(self.points, self.struck, "racket", launches)
        self.log.strokes[self.points] += 1
        return launches

    def _end(self, flight: ContactSequence, ruling: umpire.Ruling, ends: Bools) -> None:
        rows = np.flatnonzero(ends)
        flight, good = flight.take(rows), ruling.good[rows]
        time, surface = umpire.after_landing(flight, ruling.landing[rows])
        how = np.where(surface == TABLE, "double_bounce", "missed")
        end = np.where(good, time, ruling.decided[rows])
        last_visible = np.minimum(
            flight.last_visible, end + self.random.uniform(*VISIBLE_AFTER, len(rows))
        )
        points, starts, side = self.points[rows], self.struck[rows], self.side[rows]
        log = self.log
        log.add_contacts(points, starts, flight, last_visible)
        log.winner[points] = np.where(good, side, 1 - side)
        log.ended_by[points] = np.where(good, how, ruling.fault[rows])
        log.end[points], log.last_visible[points] = starts + end, starts + last_visible

    def _players(self, sides: Integers) -> Players:
        return self.players.take(self.points + sides * len(self.log.strokes))
