"""Recorded motions of arm and ball, from the launch until the ball is down."""

from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from rallygap.models.ball.contact_laws import TABLE
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Bools, Floats, Integers
from rallygap.models.policy.batch_simulation import BatchSimulation
from rallygap.models.policy.episodes import Episodes
from rallygap.models.policy.incoming_balls import (
    CONTROL_STEP,
    FLOOR,
    MAX_DURATION,
    PATH_STEP,
    IncomingBalls,
)
from rallygap.models.policy.outcome import LONGEST_FLIGHT, with_net

FRAME = 0.020  # s between two frames; the ball moves about 0.1 m
AFTERWARDS = 0.200  # s recorded after the ball is down, so that its bounce shows


@dataclass(frozen=True)
class Motion:
    """T frames, ``FRAME`` apart, from the launch on.

    Attributes:
        joints: (T, 6) of the arm, m and rad.
        ball: (T, 3) m, of the ball's centre.
    """

    joints: Floats
    ball: Floats


@dataclass
class _Recording:
    """One ball's poses (2, 6) at control steps; frame times and positions once it has ended."""

    poses: list[Floats] = field(default_factory=list)
    times: Floats | None = None
    ball: Floats | None = None


class MotionRecorder:
    """Records the first balls of a trial.

    An environment keeps stepping after its episode until the recording is complete.
    """

    def __init__(self, simulator: Simulator, incoming: IncomingBalls, count: int) -> None:
        """Prepare to record the first ``count`` of the balls."""
        self._simulator, self._incoming, self._count = with_net(simulator), incoming, count
        self._active: dict[int, _Recording] = {}
        self._motions: dict[int, Motion] = {}

    def start(self, simulation: BatchSimulation, balls: Integers, which: Bools) -> None:
        """Start recording in the environments of ``which`` (B,), which have new ``balls`` (B,)."""
        for ball in balls[which & (balls < self._count)].tolist():
            self._active[ball] = _Recording()
        self._add_poses(simulation, balls, which)

    def add(self, simulation: BatchSimulation, balls: Integers, ended: Episodes) -> None:
        """Add what one control step brought, to the environments' ``balls`` (B,)."""
        for row, ball in enumerate(balls[ended.envs].tolist()):
            if ball in self._active:
                recording = self._active[ball]
                time, after = ended.time[row], ended.after_racket[row : row + 1]
                recording.times, recording.ball = self._ball(ball, time, after)
        self._add_poses(simulation, balls, np.ones(len(balls), dtype=np.bool_))

    def active(self, balls: Integers) -> Bools:
        """Return which (B,) environments have not finished recording their ``balls`` (B,)."""
        return np.isin(balls, list(self._active))

    def motions(self) -> tuple[Motion, ...]:
        """Return the recorded motions, in the order of the balls."""
        return tuple(self._motions[ball] for ball in sorted(self._motions))

    def _add_poses(self, simulation: BatchSimulation, balls: Integers, which: Bools) -> None:
        start, arms = self._incoming.start, simulation.arms
        for env in np.flatnonzero(which & self.active(balls)):
            recording = self._active[balls[env]]
            recording.poses.append(np.stack([arms.joints[env], arms.joint_speeds[env]]))
            if recording.times is None or recording.ball is None:
                continue
            if start + CONTROL_STEP * (len(recording.poses) - 1) >= recording.times[-1]:
                joints = _joints(recording.poses, recording.times - start)
                self._motions[balls[env]] = Motion(joints, recording.ball)
                del self._active[balls[env]]

    def _ball(self, ball: int, hit: float, after: Floats) -> tuple[Floats, Floats]:
        """Return (T,) s and (T, 3) m of a ball: up to its hit, and on from (1, 9) after it."""
        incoming = self._incoming
        if np.isnan(hit):
            times = _frames(np.nan_to_num(incoming.playable[ball, 1], nan=MAX_DURATION))
            return times, incoming.path[ball, _steps(times), :3]
        flight = self._simulator.fly(after, _frames(LONGEST_FLIGHT))
        on_floor = FRAME * np.flatnonzero(flight.states[0, :, 2] < FLOOR)
        on_table = flight.contacts.time[flight.contacts.surface == TABLE]
        down = float(min([*on_table, *on_floor, LONGEST_FLIGHT]))
        times = _frames(hit + down + AFTERWARDS)
        away = self._simulator.fly(after, times[times >= hit] - hit).states[0, :, :3]
        return times, np.concatenate([incoming.path[ball, _steps(times[times < hit]), :3], away])


def _joints(poses: list[Floats], times: Floats) -> Floats:
    """Return (T, 6) joints at times (s) since the first control step, at rest before it.

    Between control steps they follow the cubic with the values and speeds at both ends.
    """
    values, speeds = np.stack(poses, axis=1)
    spline = CubicHermiteSpline(CONTROL_STEP * np.arange(len(poses)), values, speeds)
    return spline(np.maximum(times, 0.0))


def _frames(end: float) -> Floats:
    return FRAME * np.arange(round(end / FRAME) + 1, dtype=np.float64)


def _steps(times: Floats) -> Integers:
    return np.rint(times / PATH_STEP).astype(np.int64)
