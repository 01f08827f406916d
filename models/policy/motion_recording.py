"""Film: a policy plays one ball, recorded at an even rate for pictures."""

from contextlib import closing
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from models.ball.contact_laws import TABLE
from models.ball.simulator import Flight, Simulator
from models.policy.batch_simulation import ACTIONS, Court
from models.policy.episodes import Episodes
from models.policy.goals import Goals
from models.policy.incoming_balls import FLOOR, LONGEST, PATH_STEP, TICK, Incoming
from models.policy.outcome import LONGEST_FLIGHT, with_net
from models.policy.policy import Policy
from models.policy.settings import ObservationKind

Floats = NDArray[np.float64]

FRAME = 0.020  # s between two frames; the ball moves a tenth of a metre
AFTERWARDS = 0.200  # s that a film goes on when the ball is down, so that it is seen to bounce


@dataclass(frozen=True)
class Film:
    """T frames, ``FRAME`` apart, from the launch until the ball is down.

    Attributes:
        joints: (T, 6) of the arm.
        ball: (T, 3) m.
        returned: whether the ball landed as it must.
    """

    joints: Floats
    ball: Floats
    returned: bool


def film(
    policy: Policy, simulator: Simulator, incoming: Incoming, goals: Goals, kind: ObservationKind
) -> Film:
    """Film a policy that plays one ball; a ball that it does not meet goes on as it would.

    Args:
        policy: decides.
        simulator: flies the ball on from the racket.
        incoming: one ball, with what the policy's predictor says of it.
        goals: one, of its return.
        kind: what the policy sees.
    """
    with closing(Court(simulator, 1, kind)) as court:
        court.reset(np.ones(1, dtype=np.bool_), incoming, goals)
        poses = [_pose(court)]
        while not court.over[0]:
            ended = court.step(policy.act(court.observe())).ended
            poses.append(_pose(court))
        times, ball = _ball(simulator, incoming, ended)
        while incoming.start + TICK * (len(poses) - 1) < times[-1]:
            court.step(np.zeros((1, ACTIONS)))
            poses.append(_pose(court))
    return Film(_joints(poses, times - incoming.start), ball, bool(ended.returned[0]))


def _pose(court: Court) -> Floats:
    """Return (2, 6): joints and their speeds now."""
    return np.concatenate([court.arms.joints, court.arms.joint_speeds])


def _joints(poses: list[Floats], times: Floats) -> Floats:
    """Return (T, 6) joints at times (s) since the first tick, before which the arm was at rest.

    Between ticks they follow the cubic that has their values and speeds at both ends.
    """
    values, speeds = np.stack(poses, axis=1)
    between = CubicHermiteSpline(TICK * np.arange(len(poses)), values, speeds)
    joints: Floats = between(np.maximum(times, 0.0))
    return joints


def _ball(simulator: Simulator, incoming: Incoming, ended: Episodes) -> tuple[Floats, Floats]:
    """Return (T,) s from the launch and (T, 3) m, of a ball up to its hit and on from there."""
    hit = ended.time[0]
    if np.isnan(hit):
        times = _frames(np.nan_to_num(incoming.playable[0, 1], nan=LONGEST))
        return times, _on_its_way(incoming, times)
    physics = with_net(simulator)
    times = _frames(hit + _down(physics.fly(ended.after, _frames(LONGEST_FLIGHT))) + AFTERWARDS)
    away = physics.fly(ended.after, times[times >= hit] - hit).states[0, :, :3]
    return times, np.concatenate([_on_its_way(incoming, times[times < hit]), away])


def _down(flight: Flight) -> float:
    """Return when one ball, flown to ``_frames``, first touches the table or the floor, s."""
    on_floor = FRAME * np.flatnonzero(flight.states[0, :, 2] < FLOOR)
    on_table = flight.contacts.time[flight.contacts.surface == TABLE]
    return float(min([*on_table, *on_floor, LONGEST_FLIGHT]))


def _frames(end: float) -> Floats:
    return FRAME * np.arange(round(end / FRAME) + 1, dtype=np.float64)


def _on_its_way(incoming: Incoming, times: Floats) -> Floats:
    return incoming.path[0, np.rint(times / PATH_STEP).astype(np.int64), :3]
