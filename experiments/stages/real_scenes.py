"""Published scenes of MuJoCo on measured sets, before and after amending; ten minutes.

Every recording is held out once. A scene is audited, diagnosed on the other parts of the set, and
its ball amended. Then MuJoCo flies predictions of the held-out part, by the scene as it is and by
the code that is given back.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from experiments.folds import fold_numbers
from experiments.measured_scenes import HORIZONS, MeasuredScene
from experiments.resumed import verdicts
from experiments.simulators import PUBLISHED
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.settings import DEFAULTS
from rallygap.models.gap.verdict import Verdict
from rallygap.models.gap.verify.bootstrap import drawn_shots, interval
from rallygap.pipeline.engines.audited import audited
from rallygap.pipeline.gap.measured_shots import read_shots
from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.runtime.parallel import parallel
from rallygap.pipeline.runtime.paths import measured_sets
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage

SETS = ("tt3d", "spindoe")
# Scenes whose balls bounce.
SCENES = ("google-deepmind/competitive_robot_table_tennis", "MyoHub/myosuite")
PARTS = 3
MM, MS = 1e3, 1e3


def real_scenes(run: StageRun) -> None:
    """Write errors before and after amending, by set and scene.

    Raises:
        InputError: a set cannot be read.
    """
    folder, scratch = measured_sets(), run.scratch("verdicts")
    scenes = [
        scene
        for name in SETS
        for scene in _scenes(name, read_shots(folder / name, name).shots, scratch)
    ]
    write_json(run.report("errors.json"), _tested(scenes))


def _scenes(name: str, shots: Shots, scratch: Path) -> Iterator[MeasuredScene]:
    """Yield the scenes of a set."""
    part = fold_numbers(name, shots.groups, PARTS)
    for model in PUBLISHED:
        if model.name in SCENES:
            nominal = audited(model.build(), patience=inf).simulator
            yield MeasuredScene(name, model, nominal, shots, part, scratch / name)


def _tested(scenes: Sequence[MeasuredScene]) -> dict[str, dict[str, Any]]:
    """Return what is written of every scene, by set and scene."""
    parts = [(scene, number) for scene in scenes for number in range(PARTS)]
    results = verdicts([scene.diagnosis(number) for scene, number in parts], "verdicts")
    tasks = [
        partial(scene.errors, number, verdict)
        for (scene, number), verdict in zip(parts, results, strict=True)
    ]
    errors = list(parallel(tasks, "flights"))
    content: dict[str, dict[str, Any]] = {}
    for first, scene in zip(range(0, len(parts), PARTS), scenes, strict=True):
        own = slice(first, first + PARTS)
        result = _result(results[own], np.concatenate(errors[own], axis=1))
        content.setdefault(scene.set, {})[scene.model.name] = result
    return content


def _result(results: Sequence[Verdict], errors: Floats) -> dict[str, Any]:
    """Return what is written of a scene on a set.

    Args:
        results: verdicts, one for each part that is held out.
        errors: (3, B, 3) m, NaN where a shot has none.
    """
    before, after, floor = np.nanmean(errors, axis=1)
    # The 95 % interval of the mean fall of a shot's errors over its horizons.
    falls = errors[0] - errors[1]
    falls = np.nanmean(falls[np.isfinite(falls).any(axis=1)], axis=1)
    drawn = drawn_shots(len(falls), DEFAULTS.verify.bootstrap_draws)
    fall = np.array(interval(falls[drawn].mean(axis=1), DEFAULTS.confidence))
    return {
        "horizons_ms": [round(MS * horizon) for horizon in HORIZONS],
        "shots": np.isfinite(errors[0]).sum(axis=0).tolist(),
        "before_mm": _rounded(before),
        "after_mm": _rounded(after),
        "floor_mm": _rounded(floor),
        "fall_mm": _rounded(fall),
        "verdicts": [verdict.verdict for verdict in results],
        "leading": [
            [cause.identity for cause in verdict.causes if cause.role == "leading"]
            for verdict in results
        ],
    }


def _rounded(sizes: Floats) -> list[float]:
    return [round(MM * float(size), 1) for size in sizes]


if __name__ == "__main__":
    run_stage(real_scenes)
