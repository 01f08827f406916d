"""Published scenes of MuJoCo on measured sets (``make real-scenes``); writes ``real.json``.

Every recording is held out once. A scene is audited, diagnosed on the other parts of the set, and
its ball amended. Then MuJoCo flies predictions of the held-out part, by the scene as it is and by
the code that is given back (measured_scene.py). A killed run resumes.
"""

import os
from collections.abc import Iterator, Sequence
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.settings import DEFAULTS
from rallygap.models.gap.verdict import Verdict
from rallygap.models.gap.verify.bootstrap import drawn_shots, interval
from rallygap.pipeline.engines.audited import audited
from rallygap.pipeline.experiments.experiment import running
from rallygap.pipeline.gap.folds import fold_numbers
from rallygap.pipeline.gap.measured_shots import read_shots
from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.known_answers.answers import fingerprint, verdicts
from rallygap.pipeline.runtime.console import refuse
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.parallel import parallel
from rallygap.pipeline.runtime.paths import repository_root
from rallygap.pipeline.simulator_scenes.held_out_flights import HORIZONS
from rallygap.pipeline.simulator_scenes.measured_scene import MeasuredScene
from rallygap.pipeline.simulator_scenes.published import PUBLISHED

SETS = ("tt3d", "spindoe")
# Scenes whose balls bounce.
SCENES = ("google-deepmind/competitive_robot_table_tennis", "MyoHub/myosuite")
PARTS = 3
REPORT = Path("reports") / "simulators" / "real.json"
MM, MS = 1e3, 1e3


def real_scenes(root: Path, folder: Path) -> dict[str, dict[str, Any]]:
    """Write and return errors before and after amending, by set and scene.

    Args:
        root: of the repository.
        folder: with a folder for each set.

    Raises:
        InputError: a set cannot be read, or the experiment cannot start.
    """
    sets = {name: read_shots(folder / name, name).shots for name in SETS}
    data = " ".join(fingerprint(root, shots, PARTS) for shots in sets.values())
    with running(root, "simulator_scenes.real", data=data) as run:
        pairs = [one for named in sets.items() for one in _scenes(*named, run.scratch)]
        content = _tested(pairs)
        write_json(root / REPORT, content)
    return content


def _tested(pairs: Sequence[MeasuredScene]) -> dict[str, dict[str, Any]]:
    """Return what is written of every scene, by set and scene."""
    each = [(one, number) for one in pairs for number in range(PARTS)]
    found = verdicts([one.diagnosis(number) for one, number in each], "verdicts")
    tasks = [
        partial(one.errors, number, verdict)
        for (one, number), verdict in zip(each, found, strict=True)
    ]
    errors = list(parallel(tasks, "flights"))
    content: dict[str, dict[str, Any]] = {}
    for first, one in zip(range(0, len(each), PARTS), pairs, strict=True):
        own = slice(first, first + PARTS)
        results = content.setdefault(one.set, {})
        results[one.model.name] = _result(found[own], np.concatenate(errors[own], axis=1))
    return content


def _scenes(name: str, shots: Shots, scratch: Path) -> Iterator[MeasuredScene]:
    """Yield the scenes of a set."""
    part = fold_numbers(name, shots.groups, PARTS)
    for model in PUBLISHED:
        if model.name in SCENES:
            nominal = audited(model.build(), patience=inf).simulator
            yield MeasuredScene(name, model, nominal, shots, part, scratch / name)


def _result(found: Sequence[Verdict], errors: Floats) -> dict[str, Any]:
    """Return what is written of a scene on a set.

    Args:
        found: verdicts, one for each part that is held out.
        errors: (3, B, 3) m, NaN where a shot has none.
    """
    before, after, floor = np.nanmean(errors, axis=1)
    leading = [[one.identity for one in some.causes if one.role == "leading"] for some in found]
    return {
        "horizons_ms": [round(MS * one) for one in HORIZONS],
        "shots": np.isfinite(errors[0]).sum(axis=0).tolist(),
        "before_mm": _rounded(before),
        "after_mm": _rounded(after),
        "floor_mm": _rounded(floor),
        "fall_mm": _rounded(_fall(errors)),
        "verdicts": [one.verdict for one in found],
        "leading": leading,
    }


def _fall(errors: Floats) -> Floats:
    """Return the 95 % interval of the mean fall of a shot's errors over its horizons, m."""
    falls = errors[0] - errors[1]
    falls = np.nanmean(falls[np.isfinite(falls).any(axis=1)], axis=1)
    drawn = drawn_shots(len(falls), DEFAULTS.verify.bootstrap_draws)
    return np.array(interval(falls[drawn].mean(axis=1), DEFAULTS.confidence))


def _rounded(sizes: Floats) -> list[float]:
    return [round(MM * float(one), 1) for one in sizes]


if __name__ == "__main__":
    try:
        real_scenes(repository_root(), Path(os.environ.get("RALLYGAP_DATA", "")))
    except InputError as error:
        refuse(error)
