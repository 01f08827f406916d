"""Figures and tables of the exam show the numbers that follow from its records."""

from experiments.report.exam import confusion_figure, effect_table, items
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.web.report_items import ReportTable
from tests.experiments.exam.example_records import COMMITTED, answer, hidden, named, record

RALLYGAP = "rallygap"
RIGHT, MISSED = answer("named", named()), answer("no_gap")


def test_the_committed_tables_follow_from_the_committed_records(tmp_path):
    run = StageRun("report_experiments", COMMITTED.parents[2], None)
    tables = [item for item in items(run) if isinstance(item, ReportTable)]
    assert len(tables) == 6
    for table in tables:
        table.write(tmp_path / table.file)
        assert (tmp_path / table.file).read_bytes() == (COMMITTED.parent / table.file).read_bytes()


def test_the_confusion_matrix_has_shares_of_what_was_hidden():
    """One wind of four is called drag, and of two clean sets one has no answer."""
    wrong = answer("named", named("drag.cd"))
    given = [record(hidden(), answers=one) for one in (RIGHT, RIGHT, RIGHT, wrong)]
    given += [record(group="clean", cell="", answers=answer(one)) for one in ("no_gap", None)]
    (axes,) = confusion_figure(given, RALLYGAP).figure.axes
    shares = axes.images[0].get_array().tolist()
    assert shares == [[0.75, 0.25, 0, 0, 0, 0], [0, 0, 0.5, 0, 0, 0.5]]


def test_effects_have_their_marks_at_3_detection_limits():
    similar = hidden(indistinguishable=("frame_tilt.x",))
    given = [record(hidden(), answers=RIGHT), record(hidden(), answers=MISSED)]
    given += [record(similar, answers=RIGHT), record(hidden(), answers=MISSED, cell="size-2x")]
    given += [record(parameters=("wind.x",), not_posed="not shown")]

    (row,) = effect_table(given, RALLYGAP).table.to_dict("records")
    expected = {"hidden": "wind.x", "trials": 3, "distinguishable": 2, "solved": 2, "right": 2}
    assert row == row | expected | {"missed": 1, "wrong": 0, "not_posed": 1}
