"""The report of `exam`: rates of the exam, by group, effect and method."""

from collections.abc import Iterator

from rallygap.models.exam.scoring.rates import of_sweeps
from rallygap.pipeline.exam.answers import methods_of
from rallygap.pipeline.exam.records import RECORDS, read_records
from rallygap.pipeline.report.exam_method import confusion_figure, coverage_figure
from rallygap.pipeline.report.exam_methods import accuracy_figure, methods_figure
from rallygap.pipeline.report.exam_tables import (
    effect_table,
    group_table,
    not_posed_table,
    rate_table,
    robustness_table,
    shortfall_table,
)
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.report_items import ReportItem


def items(run: StageRun) -> Iterator[ReportItem]:
    """Yield figures and tables of the records.

    Figures leave the robustness groups out; their rates are in a table.
    """
    records = read_records(run.root / RECORDS)
    sweeps, methods = of_sweeps(records), methods_of(records)
    first = methods[0]
    yield confusion_figure(sweeps, first)
    yield accuracy_figure(sweeps, methods)
    yield coverage_figure(sweeps, first)
    yield methods_figure(sweeps, methods)
    yield rate_table(records)
    yield effect_table(records, first)
    yield group_table(records, first)
    yield robustness_table(records, first)
    yield shortfall_table(records, first)
    yield not_posed_table(records)
