"""Close the gap: compare measured shots with simulators, name the causes, amend the simulators."""

from collections.abc import Sequence
from statistics import fmean
from typing import Any

import pandas as pd

from rallygap.models.gap.amend.simulator import amended_yaml
from rallygap.models.gap.settings import DEFAULTS
from rallygap.models.gap.verdict import Verdict
from rallygap.pipeline.gap.cases import Diagnosed, cases
from rallygap.pipeline.gap.shots import SourceShots, read_training_shots
from rallygap.pipeline.io.artifacts import write_text
from rallygap.pipeline.io.metrics import place, rounded
from rallygap.pipeline.runtime.console import warn
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.parallel import parallel
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage


def close_gap(run: StageRun) -> None:
    """Diagnose the training shots of every source with every simulator, in several splits."""
    settings = run.params.close_gap
    shots = _enough(run, read_training_shots(run.root / "artifacts"))
    chosen = list(cases(shots, settings, run.seed))
    diagnosed = list(parallel([case.diagnose for case in chosen], "verdicts"))
    for pair in diagnosed:
        _write(run, pair)
    rows = [(case.source, case.simulator_name, case.split, len(case.shots)) for case in chosen]
    run.keep(cases=pd.DataFrame(rows, columns=["source", "simulator", "split", "shots"]))
    run.write_metrics(_metrics(diagnosed))


def _metrics(diagnosed: Sequence[Diagnosed]) -> dict[str, Any]:
    """Return ``{source: {simulator: {causes, removable_closed}}}``, means over splits."""
    metrics: dict[str, Any] = {}
    groups: dict[tuple[str, str], list[Verdict]] = {}
    for pair in diagnosed:
        groups.setdefault((pair.case.source, pair.case.simulator_name), []).append(pair.verdict)
    for key, verdicts in groups.items():
        values = place(metrics, key)
        values["causes"] = rounded(fmean(len(verdict.main_causes) for verdict in verdicts))
        gaps = [verdict.gap for verdict in verdicts if verdict.gap]
        closed = [gap.removable_closed for gap in gaps if gap.removable_closed is not None]
        if closed:
            values["removable_closed"] = rounded(fmean(closed))
    return metrics


def _enough(run: StageRun, shots: dict[str, SourceShots]) -> dict[str, SourceShots]:
    """Return the sources with enough shots for a verdict; warn of the others."""
    least = DEFAULTS.verify.held_out
    counts = {source: len(pool.members) for source, pool in shots.items()}
    for source, count in counts.items():
        run.log_input(source, run.input("segment", "samples.parquet"), count)
        if count < least:
            warn(f"{source} has {count} unbroken training shots; give at least {least}")
    enough = {source: shots[source] for source, count in counts.items() if count >= least}
    if not enough:
        problem = f"no source has {least} unbroken shots of more than twelve samples in train"
        raise InputError(run.input("segment", "episodes.parquet"), problem)
    return enough


def _write(run: StageRun, pair: Diagnosed) -> None:
    case = pair.case
    amended = amended_yaml(case.simulator, pair.verdict, case.source)
    write_text(run.artifact(f"{case.name}.yaml"), amended)
    write_text(run.artifact(f"{case.name}.json"), pair.verdict.to_json())


if __name__ == "__main__":
    run_stage(close_gap)
