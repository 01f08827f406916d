"""Measured shots of the arena's professionals, labelled by who won their points."""

from pathlib import Path

import numpy as np
import pandas as pd

from rallygap.models.arena.sides import SIDES
from rallygap.models.shot_quality.shots import (
    Shots,
    clearance,
    has_first_arc,
    measured_landing,
    shot_features,
    stroke_direction,
)
from rallygap.pipeline.io.episodes import MeasuredEpisode, read_episodes
from rallygap.pipeline.io.schemas import EPISODES, POINTS, read_checked
from rallygap.pipeline.runtime.errors import InputError

GROUP = "arena/pro/"


def read_professionals(artifacts: Path) -> Shots:
    """Read the good returns of all professionals' games; serves are none.

    Args:
        artifacts: the folder of all stages' artefacts.

    Raises:
        InputError: a table is missing or broken, or there is no such return.
    """
    points = read_checked(artifacts / "ingest" / "points.parquet", POINTS)
    strokes = _strokes(artifacts / "segment")
    played = _within_points(strokes, points[points["recording_id"].str.startswith(GROUP)])
    rows, landings, heights = [], [], []
    for row in played.index.to_numpy():
        landed = measured_landing(strokes[row].episode)
        if landed is not None and strokes[row].unbroken:
            rows.append(row)
            landings.append(landed[0])
            heights.append(landed[1])
    if not rows:
        problem = "has no return of a professional; ingest more games of the arena"
        raise InputError(artifacts / "ingest" / "points.parquet", problem)
    chosen = played.loc[rows]
    return Shots(
        shot_features(np.array(landings), clearance(np.array(heights))),
        chosen["wins"].to_numpy(dtype=np.bool_),
        chosen["point"].to_numpy(dtype=np.bool_),
        pd.factorize(chosen["recording_id"])[0],
    )


def _strokes(folder: Path) -> list[MeasuredEpisode]:
    """Return the professionals' episodes that start with a stroke."""
    table = read_checked(folder / "episodes.parquet", EPISODES)
    struck = set(table.loc[table["starts_with"] == "racket", "episode_id"])
    return [
        measured
        for measured in read_episodes(folder, labelled_once=set())
        if measured.recording_id.startswith(GROUP)
        and measured.episode_id in struck
        and has_first_arc(measured.episode)
    ]


def _within_points(strokes: list[MeasuredEpisode], points: pd.DataFrame) -> pd.DataFrame:
    """Return the strokes that were played in points, indexed by their row in ``strokes``.

    Columns are ``recording_id``, ``point``: whether the striking player won the point in the end,
    and ``wins``: whether this was also that player's last stroke of it.
    """
    directions = np.array([stroke_direction(stroke.episode) for stroke in strokes])
    columns = {
        "recording_id": [stroke.recording_id for stroke in strokes],
        "t": [float(stroke.episode.times[0]) for stroke in strokes],
        "side": np.where(directions > 0, *SIDES),  # near for strokes towards +y
    }
    table = pd.DataFrame(columns).reset_index(names="row")
    both = table.merge(points.reset_index(names="number"), on="recording_id")
    played = both[both["t"].between(both["start"], both["end"])].sort_values(["number", "t"])
    point = played["side"] == played["winner"]
    last = ~played.duplicated(["number", "side"], keep="last")
    return played.assign(point=point, wins=point & last).set_index("row")
