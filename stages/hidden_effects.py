"""Scores of the exam's records, and a few of its questions run again."""

from collections.abc import Sequence

import numpy as np

from rallygap.models.exam.records import ExamRecord
from rallygap.models.exam.scoring.rates import of_robustness, of_sweeps, rates
from rallygap.models.gap.fit.shots import spread_evenly
from rallygap.pipeline.exam.figures import exam_figures
from rallygap.pipeline.exam.records import RECORDS, read_records
from rallygap.pipeline.exam.run import assignments, run_questions
from rallygap.pipeline.exam.tables import different_answers, exam_tables, methods_of, rerun_table
from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.runtime.console import warn
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage


def hidden_effects(run: StageRun) -> None:
    """Report the rates of the kept records, and whether questions run again have their answers."""
    path = run.root / RECORDS
    records = read_records(path)
    run.log_input("exam records", path, len(records))
    rerun = _rerun(run, records)
    different = different_answers(rerun, records)
    if different:
        warn(f"{len(different)} of {len(rerun)} answers differ from {RECORDS}; run `make exam`")
    first, *others = methods = methods_of(records)
    results = {
        **_counts(of_sweeps(records), ""),
        **_counts(of_robustness(records), "_new"),
        **rates(records, first),
        "compared": {name: rates(records, name) for name in others},
    }
    write_json(run.report("exam.json"), results)
    numbers = {name: value for name, value in results.items() if isinstance(value, int | float)}
    counts = {"questions": len(rerun), "different": len(different)}
    run.write_metrics({"exam": numbers, "rerun": counts})
    run.add(*exam_figures(records, methods), *exam_tables(records, first))
    run.add(rerun_table(rerun, different))


def _counts(records: Sequence[ExamRecord], suffix: str) -> dict[str, int]:
    not_posed = sum(record.not_posed is not None for record in records)
    return {f"questions{suffix}": len(records), f"not_posed{suffix}": not_posed}


def _rerun(run: StageRun, records: Sequence[ExamRecord]) -> list[ExamRecord]:
    """Run a few questions, evenly spaced over the records, and note the time of each method."""
    names = {record.name for record in records}
    asked = assignments(run.params)
    known = [(question, methods) for question, methods in asked if question.trial.name in names]
    if len(known) < len(asked):
        warn(f"{len(asked) - len(known)} questions have no record; run `make exam`")
    count = min(run.params.hidden_effects.rerun_questions, len(known))
    chosen = [known[k] for k in spread_evenly(len(known), count)]
    rerun = run_questions(chosen, run.scratch("records"))
    for method in sorted({name for record in rerun for name in record.seconds}):
        seconds = [record.seconds[method] for record in rerun if method in record.seconds]
        run.timings[f"{method}_cpu_s_median"] = float(np.median(seconds))
    return rerun


if __name__ == "__main__":
    run_stage(hidden_effects)
