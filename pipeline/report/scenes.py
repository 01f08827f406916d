"""Scenes of the report page's 3-D views, in the form that their script reads.

A scene has a moving ball, measured positions, forecasts that are each valid until the next one, and
perhaps an arm. Times are s, positions m in the table frame.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from rallygap.models.robot.constants import BASE, BLADE, JOINTS, RACKET_RADIUS
from rallygap.pipeline.evaluation.example_shots import Forecast, Shot
from rallygap.pipeline.report.plots import physics_colour
from rallygap.pipeline.transfer.shown_returns import Return
from rallygap.pipeline.web.environment import table_geometry

DRAWN = ("shoulder", "elbow", "wrist_yaw")  # joints at which the drawn links meet


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
        "colours": {name: physics_colour(name) for name in names},
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
    return {"from": start, **forecast.model_dump()}


def _return_scene(played: Return) -> dict[str, Any]:
    first, last = played.ball.t[0], played.ball.t[-1]
    met = last if played.hit is None else played.hit
    points, normals = arm_lines(played.joints)
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
        "arm": {
            "t": (played.frame * np.arange(len(points))).round(6).tolist(),
            "links": points.round(3).reshape(len(points), -1).tolist(),
            "normal": normals.round(3).tolist(),
        },
    }


def arm_lines(joints: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the arm at T poses.

    Args:
        joints: (T, 6).

    Returns:
        (T, 4, 3) m: shoulder, elbow, wrist and the racket's centre; (T, 3) the racket's normal.
    """
    values = np.asarray(joints, dtype=np.float64)
    rotation, point = Rotation.identity(len(values)), np.tile(BASE, (len(values), 1))
    corners = []
    for joint, value in zip(JOINTS, values.T, strict=True):
        point = point + rotation.apply(joint.origin)
        rotation = rotation * Rotation.from_euler("x", joint.pitch)
        if joint.kind == "prismatic":
            point = point + rotation.apply(np.outer(value, np.eye(3)["xyz".index(joint.axis)]))
        else:
            rotation = rotation * Rotation.from_euler(joint.axis, value[:, None])
        if joint.name in DRAWN:
            corners.append(point)
    return np.stack([*corners, point + rotation.apply(BLADE)], axis=1), rotation.apply([0, 1, 0])
