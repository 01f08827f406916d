"""The generated table of questions in docs/exam.md."""

from pathlib import Path

import pandas as pd

from rallygap.pipeline.io.markdown import markdown_table

GROUPS = {
    "sweep": "one hidden parameter of the catalogue. The base has 3 detection limits, 100 shots "
    "and 3 mm noise; the other cells change one of them",
    "clean": "nothing hidden; all kinds of spin labels, one or two directions",
    "pair": "two causes from different families, each at 3 detection limits",
    "sensor_fault": "a sensor effect, measured by cameras with more noise, outliers and dropouts",
    "nominal_off": "a missing effect, and a wrong value of one of the simulator's own parameters",
    "withheld": "an effect that is removed from the methods' catalogue",
    "unlabelled": "one hidden parameter, no spin labels",
    "one_direction": "one hidden parameter, all shots in one direction",
    "label_kind": "label errors of rows, arcs, shots (all rows or one label) or of the session",
    "distortion": "a smooth position error field, Gaussian, radial or in half of the room",
    "heavy_tails": "t distributions of position errors, of bounce scatter or of both",
    "time_stamps": "rounded or jittered time stamps",
    "frame_rate": "50 to 250 Hz",
    "drift": "a parameter that changes linearly over the session",
    "shot_variation": "a parameter that differs from shot to shot",
    "place": "a cause in half of the room",
    "several": "three to six causes, each at 3 detection limits or more",
    "far_off": "a nominal simulator that is far off, and a missing effect",
}


def questions_table(root: Path) -> str:
    """Return the groups of questions with their sizes, as Markdown."""
    table = pd.read_csv(root / "reports" / "exam" / "groups.csv")
    counts = table.groupby("group", sort=False)[["questions", "not_posed"]].sum()
    rows = [
        [f"`{group}`", f"{row.questions:,}", row.not_posed, GROUPS[str(group)]]
        for group, row in counts.iterrows()
    ]
    total = counts.sum()
    rows.append(["all", f"{total.questions:,}", total.not_posed, ""])
    return markdown_table(["group", "questions", "not posed", "content"], rows)
