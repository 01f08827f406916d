"""Figures of the exam, from its records."""

from collections.abc import Sequence

from rallygap.models.exam.records import ExamRecord
from rallygap.models.exam.scoring.rates import of_sweeps
from rallygap.pipeline.exam.figures.methods import accuracy_figure, methods_figure
from rallygap.pipeline.exam.figures.single_method import confusion_figure, coverage_figure
from rallygap.pipeline.io.report_items import ReportFigure


def exam_figures(records: Sequence[ExamRecord], methods: Sequence[str]) -> list[ReportFigure]:
    """Return the figures of an exam, those of a single method for the first one.

    The robustness groups are left out; their rates are in a table.
    """
    records = of_sweeps(records)
    return [
        confusion_figure(records, methods[0]),
        accuracy_figure(records, methods),
        coverage_figure(records, methods[0]),
        methods_figure(records, methods),
    ]
