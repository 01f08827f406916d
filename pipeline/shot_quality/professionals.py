"""Shots of the arena's professionals: what the cameras saw of them, and who won their points."""

from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from models.arena.sides import SIDES
from models.shot_quality.measured_landings import landing, seen_flying, struck_towards
from models.shot_quality.shots import Shots, clearance, described
from pipeline.io.episodes import MeasuredEpisode, read_episodes
from pipeline.io.schemas import EPISODES, POINTS, read_checked
from pipeline.runtime.errors import InputError

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
    found = [(row, landing(strokes[row].episode)) for row in played.index.to_numpy()]
    good = [(row, *one) for row, one in found if one is not None and strokes[row].unbroken]
    if not good:
        problem = "has no return of a professional; ingest more games of the arena"
        raise InputError(artifacts / "ingest" / "points.parquet", problem)
    rows, landings, heights = zip(*good, strict=True)
    chosen = played.loc[list(rows)]
    return Shots(
        described(np.array(landings), clearance(np.array(heights))),
        chosen["wins"].to_numpy(dtype=np.bool_),
        chosen["point"].to_numpy(dtype=np.bool_),
        pd.factorize(chosen["recording_id"])[0],
    )


def _strokes(folder: Path) -> list[MeasuredEpisode]:
    """Return the professionals' episodes that begin with a stroke."""
    table = read_checked(folder / "episodes.parquet", EPISODES)
    struck = set(table.loc[table["starts_with"] == "racket", "episode_id"])
    episodes = read_episodes(folder, labelled_once=set())
    return [
        one
        for one in episodes
        if one.recording_id.startswith(GROUP)
        and one.episode_id in struck
        and seen_flying(one.episode)
    ]


def _within_points(strokes: list[MeasuredEpisode], points: pd.DataFrame) -> pd.DataFrame:
    """Return the strokes that were played in points, by their place, and what came of them.

    Columns are ``recording_id``, ``point``: whether the one who struck won it in the end, and
    ``wins``: with this very stroke, the last that was theirs.
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
    ways = np.array([struck_towards(one.episode) for one in strokes])
    return np.where(ways > 0, *SIDES)
