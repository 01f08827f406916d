"""Scenes of MuJoCo and PyBullet with something wrong, diagnosed and amended; ten minutes.

Published models are audited. Games are played with larger spins than published ones. And recordings
are simulated under the hidden physics; every scene is audited and diagnosed on them, and its ball
amended. Then the scene as it is, and with the amended ball, fly other shots in their own engine.
They start from their true launches, so a correct simulator errs by nothing.
"""

from functools import partial
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from experiments.exam.interface import shots_of
from experiments.exam.simulate.recordings import simulate_trial
from experiments.exam.simulate.trial import Trial
from experiments.resumed import json_results
from experiments.simulators import PUBLISHED, TRUTH, HiddenScene, larger_spins, scenes
from rallygap.models.audit.launches import launches
from rallygap.models.audit.traps import traps
from rallygap.models.ball.state import POSITION
from rallygap.models.ball.types import Floats
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.gap.diagnose import diagnose
from rallygap.pipeline.engines.audit_text import audit_content
from rallygap.pipeline.engines.audited import audited
from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage

SHOTS, TESTED = 100, 40  # to diagnose on, and to fly
TIMES: Floats = np.array([0.1, 0.2, 0.3, 0.4])  # s
MM = 1e3
NO_TABLE = "no_table"  # a trap, but not of a scene that leaves it out


def simulators(run: StageRun) -> None:
    """Write audits of published models, games with larger spins, and what becomes of scenes."""
    contents = {
        "published": published_models(),
        "larger_spins": larger_spins(),
        "scenes": simulator_scenes(run.scratch("scenes")),
    }
    for name, content in contents.items():
        write_json(run.report(f"{name}.json"), content)


def simulator_scenes(scratch: Path) -> dict[str, dict[str, Any]]:
    """Return what becomes of every scene, by engine and scene.

    Args:
        scratch: folder of what a killed run leaves to the next one.
    """
    chosen = list(scenes())
    files = [scratch / f"{scene.engine}-{scene.name}.json" for scene in chosen]
    tasks = [partial(scene_result, scene) for scene in chosen]
    results = json_results(dict(zip(files, tasks, strict=True)), "scenes")
    content: dict[str, dict[str, Any]] = {}
    for scene, result in zip(chosen, results, strict=True):
        content.setdefault(scene.engine, {})[scene.name] = result
    return content


def published_models() -> dict[str, dict[str, Any]]:
    """Return the audits of published models."""
    content = {}
    for model in PUBLISHED:
        audit = audited(model.build(), patience=inf)
        known = tuple(trap for trap in traps(audit) if model.bounces or trap.identifier != NO_TABLE)
        described = {"file": model.file, "says": model.says}
        content[model.name] = described | audit_content(model.name, audit, known)
    return content


def scene_result(scene: HiddenScene) -> dict[str, Any]:
    """Return what becomes of a scene: its leading causes, and its errors before and after."""
    engine = scene.build()
    audit = audited(engine, patience=inf)
    recordings = shots_of(simulate_trial(Trial("scenes", TRUTH, shots=SHOTS))[0])
    verdict = diagnose(recordings, audit.simulator)
    leading = [cause.identity for cause in verdict.causes if cause.role == "leading"]
    tested = launches(TRUTH, TESTED, 2, np.random.default_rng(1)).states
    before = _error(engine.fly(tested, TIMES), tested)
    known = amended(audit.simulator, verdict)
    after = _error(scene.fly_amended(known, tested, TIMES), tested)
    return {
        "hidden": scene.hidden,
        "traps": [trap.identifier for trap in traps(audit)],
        "verdict": verdict.verdict,
        "leading": leading,
        "named_right": bool(set(scene.causes) & set(leading)),
        "before_mm": before,
        "after_mm": after,
        "floor_mm": 0.0,
        "removable_closed": round(1.0 - after / before, 3),
    }


def _error(flown: Floats, launched: Floats) -> float:
    """Return the mean distance from the true flights over shots and times, mm."""
    true = TRUTH.fly(launched, TIMES).states
    distances = np.linalg.norm((flown - true)[..., POSITION], axis=-1)
    return float(f"{MM * distances.mean():.4g}")


if __name__ == "__main__":
    run_stage(simulators)
