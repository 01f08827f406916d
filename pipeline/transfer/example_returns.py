"""Example shots for the report page: the recorded motion and the forecasts at every step."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.policy.incoming_balls import FIRST_WINDOW, PATH_STEP, control_times
from rallygap.models.policy.motion_recording import FRAME
from rallygap.models.policy.outcome import with_net
from rallygap.models.policy.trial import TrialResult
from rallygap.models.predictors.protocol import FUTURE_TIMES
from rallygap.models.replay.replayed_balls import Histories, measurement_histories, predict_all
from rallygap.pipeline.policies.storage import TrainedPolicy
from rallygap.pipeline.runtime.torch_threads import one_thread
from rallygap.pipeline.transfer.replay_sets import ReplaySet
from rallygap.pipeline.transfer.replay_trials import ReplayTrial
from rallygap.pipeline.transfer.returns import EVERY_STEP, PHYSICS
from rallygap.pipeline.transfer.shown_returns import Return, TimedForecast, Track
from rallygap.pipeline.transfer.trials import Played

EXAMPLES = 2  # per set
BALL_STEP = 0.005  # s between two points of the ball's path
SHOWN = slice(3, None, 4)  # of the states of a forecast: every 20 ms


@dataclass(frozen=True)
class _Example:
    """A shot of a set, the policy, and what the predictors get and forecast."""

    shots: ReplaySet
    trained: TrainedPolicy
    ball: int
    histories: Histories
    forecasts: Mapping[str, Floats]


def example_returns(
    trials: Sequence[tuple[ReplayTrial, Played]], learned: Sequence[str]
) -> list[Return]:
    """Return examples of a set, with its most accurate learned predictor and with physics.

    Args:
        trials: of the set, with their results; the first policy's trials with physics and with
            the learned predictors must be recorded.
        learned: names of the learned predictors.
    """
    shots, (_, trained) = trials[0][0].shots, trials[0][0].policies[0]
    predictors = {
        trial.forecaster.name: trial.forecaster.predictor
        for trial, _ in trials
        if trial.forecaster.mode == EVERY_STEP
    }
    played = {
        trial.forecaster.name: result.recorded
        for trial, result in trials
        if result.recorded is not None
    }
    errors = {name: played[name].table["forecast_error_m"].mean() for name in learned}
    compared = [min(learned, key=errors.__getitem__), PHYSICS]
    returned = pd.DataFrame({name: played[name].table["returned"] for name in compared})
    examples = []
    for ball in choose(returned, EXAMPLES):
        histories = measurement_histories([shots.shots[ball]])
        with one_thread():
            forecasts = {
                name: predict_all(predictors[name], histories.history) for name in compared
            }
        example = _Example(shots, trained, ball, histories, forecasts)
        examples += [_return(example, name, played[name]) for name in compared]
    return examples


def choose(returned: pd.DataFrame, count: int) -> list[int]:
    """Return the shots of a set to show.

    First those that the first predictor alone returns, then others with different outcomes, then
    those always returned, then the others; each in the order of the set.

    Args:
        returned: whether each shot (row) is returned with each predictor (column).
        count: the largest number of shots.
    """
    differ, all_returned = returned.nunique(axis=1) > 1, returned.all(axis=1)
    first = returned.iloc[:, 0]
    order = np.lexsort((returned.index, ~all_returned, ~first, ~differ))
    return [int(ball) for ball in returned.index[order][:count]]


def _return(example: _Example, predictor: str, played: TrialResult) -> Return:
    shots, ball, horizons = example.shots, example.ball, example.trained.horizons
    ended, motion = played.table.iloc[ball], played.motions[ball]
    hit, end = float(ended["time"]), FRAME * (len(motion.joints) - 1)
    after = played.after_racket[ball]
    times, positions = _ball(shots.simulator, shots.path[ball], hit, after, end)
    measured = shots.shots[ball].measured
    gone = end if np.isnan(hit) else hit
    kept = ~measured.outlier & (measured.times <= gone)
    return Return(
        name=f"{shots.name} {ball}",
        predictor=predictor,
        outcome=ended["fault"].replace("_", " ") or "returned",
        horizon=horizons[len(horizons) // 2] / 1000,
        hit=None if np.isnan(hit) else round(hit, 6),
        measured=_track(measured.times[kept], measured.positions[kept]),
        ball=_track(times, positions),
        frame=FRAME,
        joints=[tuple(pose) for pose in np.round(motion.joints, 4).tolist()],
        forecasts={
            name: _timed(forecast, example.histories, gone)
            for name, forecast in example.forecasts.items()
        },
    )


def _ball(
    simulator: Simulator, path: Floats, hit: float, state: Floats, end: float
) -> tuple[Floats, Floats]:
    """Return (S,) s and (S, 3) m of a ball, up to its hit and on from the (9,) state after it."""
    times = BALL_STEP * np.arange(round(end / BALL_STEP) + 1, dtype=np.float64)
    if np.isnan(hit):
        return times, path[np.rint(times / PATH_STEP).astype(np.int64), :3]
    before = times[times < hit]
    coming = path[np.rint(before / PATH_STEP).astype(np.int64), :3]
    after = np.concatenate([[hit], times[times > hit]])
    away: Floats = with_net(simulator).fly(state, after - hit).states[0, :, :3]
    return np.concatenate([before, after]), np.concatenate([coming, away])


def _timed(forecast: Floats, histories: Histories, gone: float) -> list[TimedForecast]:
    """Return the forecasts (S, 60, 9) of one ball at the control steps until it was gone."""
    timed = []
    for step, time in enumerate(control_times(FIRST_WINDOW)):
        if time <= gone:
            ahead = time - histories.age[0, step] + FUTURE_TIMES[SHOWN]
            states = forecast[histories.latest[0, step], SHOWN]
            track = _track(ahead, states[:, :3])
            timed.append(TimedForecast(at=round(float(time), 6), track=track))
    return timed


def _track(times: Floats, positions: Floats) -> Track:
    points = [(x, y, z) for x, y, z in np.round(positions, 4).tolist()]
    return Track(t=np.round(times, 6).tolist(), position=points)
