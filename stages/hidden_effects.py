"""Scores of the exam's records, and a few of its questions run again."""

from collections.abc import Sequence

import numpy as np

from rallygap.models.exam.records import ExamRecord
from rallygap.models.exam.scoring.rates import rates
from rallygap.models.exam.scoring.robustness import of_robustness, of_sweeps
from rallygap.models.gap.fit.shots import spread_evenly
from rallygap.pipeline.exam.answers import answer_rows, different_answers, methods_of
from rallygap.pipeline.exam.records import RECORDS, read_records
from rallygap.pipeline.exam.run import assignments, run_questions
from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.runtime.console import warn
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage

HEADLINES = ("false_alarm_rate", "top1_at_3x", "coverage", "removable_closed")  # of ``rates``


def hidden_effects(run: StageRun) -> None:
    """Report the rates of the kept records, and whether questions run again have their answers."""
    path = run.root / RECORDS
    records = read_records(path)
    run.log_input("exam records", path, len(records))
    rerun = _rerun(run, records)
    different = different_answers(rerun, records)
    if different:
        warn(f"{len(different)} of {len(rerun)} answers differ from {RECORDS}; run the exam again")
    first, *others = methods_of(records)
    results = {
        **_counts(of_sweeps(records), ""),
        **_counts(of_robustness(records), "_new"),
        **rates(records, first),
        "compared": {name: rates(records, name) for name in others},
    }
    write_json(run.artifact("exam.json"), results)
    answers = answer_rows(rerun, methods_of(rerun))
    run.keep(rerun=answers.assign(as_recorded=~answers["trial"].isin(different)))
    metrics = {name: results[name] for name in HEADLINES}
    run.write_metrics({**metrics, "rerun": len(rerun), "rerun_different": len(different)})


def _counts(records: Sequence[ExamRecord], suffix: str) -> dict[str, int]:
    not_posed = sum(record.not_posed is not None for record in records)
    return {f"questions{suffix}": len(records), f"not_posed{suffix}": not_posed}


def _rerun(run: StageRun, records: Sequence[ExamRecord]) -> list[ExamRecord]:
    """Run a few questions, evenly spaced over the records, and note the time of each method."""
    known = {record.name for record in records}
    asked = assignments(run.params)
    whole = [one for one in asked if one[0].trial.name in known]
    if len(whole) < len(asked):
        warn(f"{len(asked) - len(whole)} questions have no record; run the exam again")
    count = min(run.params.hidden_effects.rerun_questions, len(whole))
    chosen = [whole[k] for k in spread_evenly(len(whole), count)]
    results = run_questions(chosen, run.scratch("records"))
    for method in sorted({name for result in results for name in result.seconds}):
        seconds = [result.seconds[method] for result in results if method in result.seconds]
        run.timings[f"{method}_cpu_s_median"] = float(np.median(seconds))
    return [result.record for result in results]


if __name__ == "__main__":
    run_stage(hidden_effects)
