"""Films of replayed balls: which of them, and everything that moved while a policy played them."""

from collections.abc import Mapping, Sequence
from contextlib import closing

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.ball.simulator import Simulator
from models.policy.batch_simulation import Court
from models.policy.episodes import Episodes
from models.policy.goals import Goals
from models.policy.incoming_balls import FIRST_WINDOW, PATH_STEP, Incoming, tick_times
from models.policy.motion_recording import FRAME, Film, film
from models.policy.outcome import with_net
from models.policy.policy import Policy
from models.policy.settings import ObservationKind
from models.predictors.protocol import FUTURE_TIMES
from models.replay.replayed_balls import Views, every_tick, predicted, views
from pipeline.evaluation.predictors import one_thread
from pipeline.policies.storage import TrainedPolicy
from pipeline.transfer.example_returns import Return, Told, Track
from pipeline.transfer.replay_sets import ReplaySet
from pipeline.transfer.replay_trials import EveryTick

Floats = NDArray[np.float64]

BALL_STEP = 0.005  # s between two points of the ball's path
SHOWN = slice(3, None, 4)  # of the states of a forecast: every 20 ms


def chosen(played: pd.DataFrame, predictors: Sequence[str], count: int) -> list[int]:
    """Return the balls of a set to be filmed.

    Those come first that end differently with different predictors, then those that are returned
    with all, then all others; among equals, the first that were replayed.

    Args:
        played: trials of one policy, a row a predictor and ball: ``predictor``, ``ball`` and
            ``returned``.
        predictors: that are compared.
        count: how many balls, at most.
    """
    ended = played.pivot(index="ball", columns="predictor", values="returned")[list(predictors)]
    differ, all_returned = ended.nunique(axis=1) > 1, ended.all(axis=1)
    order = np.lexsort((ended.index, ~all_returned, ~differ))
    return [int(ball) for ball in ended.index[order][:count]]


def filmed(
    shots: ReplaySet,
    ball: int,
    goals: Goals,
    player: tuple[Policy, TrainedPolicy],
    forecasters: Sequence[EveryTick],
) -> list[Return]:
    """Return how a policy plays a ball, told of it by each of some forecasters.

    Args:
        shots: the set of the ball.
        ball: its number among them.
        goals: of all balls of the set.
        player: the policy, and what it was trained for.
        forecasters: all of their forecasts are kept with each return.
    """
    policy, trained = player
    seen = views([shots.shots[ball]])
    with one_thread():
        forecasts = {one.name: predicted(one.predictor, seen.history) for one in forecasters}
    returns = []
    for one in forecasters:
        told = every_tick(forecasts[one.name], seen, trained.horizons)
        rows = slice(ball, ball + 1)
        incoming = Incoming(shots.path[rows], shots.playable[rows], FIRST_WINDOW, told)
        case = (policy, shots.simulator, incoming, goals[rows], trained.observation)
        ended, moved = _ended(*case), film(*case)
        returns.append(_return(shots, ball, trained, one.name, ended, moved, seen, forecasts))
    return returns


def _ended(
    policy: Policy, simulator: Simulator, incoming: Incoming, goals: Goals, kind: ObservationKind
) -> Episodes:
    """Return how one ball ended."""
    with closing(Court(simulator, 1, kind)) as court:
        court.reset(np.ones(1, dtype=np.bool_), incoming, goals)
        while not court.over[0]:
            ended = court.step(policy.act(court.observe())).ended
    return ended


def _return(
    shots: ReplaySet,
    ball: int,
    trained: TrainedPolicy,
    told_by: str,
    ended: Episodes,
    moved: Film,
    seen: Views,
    forecasts: Mapping[str, Floats],
) -> Return:
    hit, end = float(ended.time[0]), FRAME * (len(moved.joints) - 1)
    times, places = _ball(shots.simulator, shots.path[ball], ended, end)
    measured = shots.shots[ball].measured
    gone = end if np.isnan(hit) else hit
    kept = ~measured.outlier & (measured.times <= gone)
    return Return(
        name=f"{shots.name} {ball}",
        told_by=told_by,
        outcome=str(ended.fault[0]).replace("_", " ") or "returned",
        horizon=trained.horizons[len(trained.horizons) // 2] / 1000,
        hit=None if np.isnan(hit) else round(hit, 6),
        measured=_track(measured.times[kept], measured.positions[kept]),
        ball=_track(times, places),
        frame=FRAME,
        joints=[tuple(pose) for pose in np.round(moved.joints, 4).tolist()],
        forecasts={name: _told(own, seen, gone) for name, own in forecasts.items()},
    )


def _ball(simulator: Simulator, path: Floats, ended: Episodes, end: float) -> tuple[Floats, Floats]:
    """Return (S,) s and (S, 3) m: the ball up to its hit, the hit, and on from there."""
    times = BALL_STEP * np.arange(round(end / BALL_STEP) + 1, dtype=np.float64)
    hit = float(np.nan_to_num(ended.time[0], nan=np.inf))
    before = times[times < hit]
    coming = path[np.rint(before / PATH_STEP).astype(np.int64), :3]
    if np.isinf(hit):
        return before, coming
    after = np.concatenate([[hit], times[times > hit]])
    away: Floats = with_net(simulator).fly(ended.after, after - hit).states[0, :, :3]
    return np.concatenate([before, after]), np.concatenate([coming, away])


def _told(forecast: Floats, seen: Views, gone: float) -> list[Told]:
    """Return the forecasts of one ball, (S, 60, 9), as they were made until it was gone."""
    told = []
    for tick, time in enumerate(tick_times(FIRST_WINDOW)):
        if time <= gone:
            ahead = time - seen.age[0, tick] + FUTURE_TIMES[SHOWN]
            states = forecast[seen.latest[0, tick], SHOWN]
            told.append(Told(at=round(float(time), 6), track=_track(ahead, states[:, :3])))
    return told


def _track(times: Floats, positions: Floats) -> Track:
    places = [(x, y, z) for x, y, z in np.round(positions, 4).tolist()]
    return Track(t=np.round(times, 6).tolist(), position=places)
