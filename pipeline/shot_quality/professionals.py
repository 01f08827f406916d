"""Measured shots of the arena's professionals, labelled by who won their points."""

from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from rallygap.models.arena.sides import SIDES
from rallygap.models.shot_quality.measured_landings import has_first_arc, landing, stroke_direction
from rallygap.models.shot_quality.shots import Shots, clearance, shot_features
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
    landed = [(row, landing(strokes[row].episode)) for row in played.index.to_numpy()]
    good = [(row, *one) for row, one in landed if one is not None and strokes[row].unbroken]
    if not good:
        problem = "has no return of a professional; ingest more games of the arena"
        raise InputError(artifacts / "ingest" / "points.parquet", problem)
    rows, landings, heights = zip(*good, strict=True)
    chosen = played.loc[list(rows)]
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
    episodes = read_episodes(folder, labelled_once=set())
    return [
        one
        for one in episodes
        if one.recording_id.startswith(GROUP)
        and one.episode_id in struck
        and has_first_arc(one.episode)
    ]


def _within_points(strokes: list[MeasuredEpisode], points: pd.DataFrame) -> pd.DataFrame:
    """Return the strokes that were played in points, indexed by their row in ``strokes``.

    Columns are ``recording_id``, ``point``: whether the striking player won the point in the end,
    and ``wins``: whether this was also that player's last stroke of it.
    """
    columns = {
        "recording_id": [one.recording_id for one in strokes],
        "t": [float(one.episode.times[0]) for one in strokes],
        "side": _sides(strokes),
    }
    each = pd.DataFrame(columns).reset_index(names="row")
    both = each.merge(points.reset_index(names="number"), on="recording_id")
    played = both[both["t"].between(both["start"], both["end"])].sort_values(["number", "t"])
    point = played["side"] == played["winner"]
    last = ~played.duplicated(["number", "side"], keep="last")
    return played.assign(point=point, wins=point & last).set_index("row")


def _sides(strokes: list[MeasuredEpisode]) -> NDArray[np.str_]:
    """Return ``near`` for strokes towards +y, ``far`` for the others."""
    directions = np.array([stroke_direction(one.episode) for one in strokes])
    return np.where(directions > 0, *SIDES)
