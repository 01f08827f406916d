"""Scenes of the report page's 3-D views, in the form that their script reads.

A scene has a moving ball, measured positions, forecasts that are each valid until the next one, and
perhaps an arm. Times are s, positions m in the table frame.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from rallygap.models.robot.constants import RACKET_RADIUS
from rallygap.pipeline.evaluation.example_shots import Forecast, Shot
from rallygap.pipeline.report.arm import arm_lines
from rallygap.pipeline.transfer.example_returns import Return
from rallygap.pipeline.web.figure_style import predictor_colour
from rallygap.pipeline.web.table_geometry import table_geometry

COLOUR_OF = {"physics": "physics_c"}  # predictor with the same colour


def shot_scenes(shots: Sequence[Shot]) -> dict[str, Any]:
    """Return measured shots with the forecasts from their start.

    The error of a forecast is its distance from the ball at the same time.
    """
    return _view([_shot_scene(shot) for shot in shots])


def return_scenes(returns: Sequence[Return]) -> dict[str, Any]:
    """Return shots that policies played.

    The error of a forecast is taken at the policy's horizon, until the racket contact.
    """
    return _view([_return_scene(played) for played in returns])


def _view(scenes: list[dict[str, Any]]) -> dict[str, Any]:
    names = sorted({name for scene in scenes for name in scene["forecasts"]})
    return {
        "scenes": scenes,
        "colours": {name: predictor_colour(COLOUR_OF.get(name, name)) for name in names},
        "table": {**table_geometry(), "racket_radius": RACKET_RADIUS},
    }


def _shot_scene(shot: Shot) -> dict[str, Any]:
    measured = {"t": shot.t, "position": shot.measured}
    last = max([shot.anchor, *(forecast.t[-1] for forecast in shot.forecasts.values())])
    return {
        "name": shot.episode_id,
        "start": shot.t[0],
        "end": max(shot.t[-1], last),
        "zero": shot.anchor,
        "shown": min(last, shot.t[-1]),
        "seen": shot.anchor,
        "measured": measured,
        "ball": measured,
        "judged": {"ahead": 0.0, "until": shot.t[-1]},
        "forecasts": {
            name: [_forecast(shot.t[0], forecast)] for name, forecast in shot.forecasts.items()
        },
        "arm": None,
    }


def _forecast(start: float, forecast: Forecast) -> dict[str, Any]:
    return {"from": start, "t": forecast.t, "position": forecast.position}


def _return_scene(played: Return) -> dict[str, Any]:
    first, last = played.ball.t[0], played.ball.t[-1]
    met = last if played.hit is None else played.hit
    return {
        "name": f"{played.name}, predictor {played.predictor.replace('_', ' ')}: {played.outcome}",
        "start": first,
        "end": last,
        "zero": met,
        "shown": max(met - played.horizon, first),
        "seen": None,
        "measured": played.measured.model_dump(),
        "ball": played.ball.model_dump(),
        "judged": {"ahead": played.horizon, "until": met},
        "forecasts": {
            name: [_forecast(timed.at, timed.track) for timed in timed_forecasts]
            for name, timed_forecasts in played.forecasts.items()
        },
        "arm": _arm(played),
    }


def _arm(played: Return) -> dict[str, Any]:
    points, normals = arm_lines(played.joints)
    return {
        "t": (played.frame * np.arange(len(points))).round(6).tolist(),
        "links": points.round(3).reshape(len(points), -1).tolist(),
        "normal": normals.round(3).tolist(),
    }
