"""The blind exam: every question, and what verdicts cost; two and a half hours on two cores."""

from collections.abc import Sequence

import pandas as pd

from experiments.exam.methods.registry import RALLYGAP
from experiments.exam.records import RECORDS, ExamRecord, write_records
from experiments.exam.scoring.rates import rates
from experiments.exam.whole import assignments, run_questions
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage

HEADLINES = ("false_alarm_rate", "top1_at_3x", "coverage", "removable_closed")  # of ``rates``


def exam(run: StageRun) -> None:
    """Run all questions; write their records, and the costs of verdicts."""
    records = run_questions(assignments(run.params), run.scratch("records"))
    write_records(run.root / RECORDS, records)
    run.publish({"costs": verdict_costs(records)}, digits=3)
    numbers = rates(records, RALLYGAP)
    run.write_metrics({name: numbers[name] for name in HEADLINES})


def verdict_costs(records: Sequence[ExamRecord]) -> pd.DataFrame:
    """Return the CPU seconds of verdicts: one row a method and number of shots."""
    rows = [
        {"method": method, "shots": record.shots, "seconds": seconds}
        for record in records
        for method, seconds in record.seconds.items()
    ]
    keys = ["method", "shots"]
    groups = pd.DataFrame(rows, columns=[*keys, "seconds"]).groupby(keys, sort=True)["seconds"]
    columns = {
        "verdicts": groups.size(),
        "cpu_s_median": groups.median(),
        "cpu_s_p95": groups.quantile(0.95),
        "cpu_s_total": groups.sum(),
    }
    return pd.DataFrame(columns).reset_index()


if __name__ == "__main__":
    run_stage(exam)
