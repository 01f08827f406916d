"""Reading the reported errors, with errors that name the place."""

import shutil
from pathlib import Path

import pandas as pd
import pytest

from rallygap.pipeline.evaluation.error_table import KEYS, NUMBERS, REPORT, read_errors
from rallygap.pipeline.runtime.errors import InputError

REPOSITORY = Path(__file__).parents[3]


@pytest.fixture
def root(tmp_path):
    """A repository with the committed report."""
    (tmp_path / REPORT).parent.mkdir(parents=True)
    shutil.copy(REPOSITORY / REPORT, tmp_path / REPORT)
    return tmp_path


def test_the_committed_report_is_read(root):
    plain = pd.read_csv(root / REPORT)
    read = read_errors(root)
    assert list(read) == [*KEYS, *NUMBERS]
    assert read.to_dict("records") == plain.to_dict("records")


def test_integers_and_a_numeric_set_name_are_accepted(root):
    row = "7,measured,tae,spin,all,100,3,2.5,1,9,2,4"
    (root / REPORT).write_text(f"{','.join([*KEYS, *NUMBERS])}\n{row}\n")
    (read,) = read_errors(root).to_dict("records")
    assert (read["set"], read["mean"]) == ("7", 3.0)


@pytest.mark.parametrize("column", [*KEYS, *NUMBERS])
def test_a_column_that_is_missing_is_named_with_the_stage_to_run(root, column):
    pd.read_csv(root / REPORT).drop(columns=column).to_csv(root / REPORT, index=False)
    with pytest.raises(InputError, match=rf"forecast_error\.csv.*{column}.*evaluate_predictor"):
        read_errors(root)


@pytest.mark.parametrize("value", ["long", "", "inf", "0x7f"])
@pytest.mark.parametrize("column", ["horizon_ms", *NUMBERS])
def test_an_invalid_number_is_named(root, column, value):
    report = pd.read_csv(root / REPORT).astype({column: object})
    report.loc[2, column] = value
    report.to_csv(root / REPORT, index=False)
    with pytest.raises(InputError, match=rf"forecast_error\.csv.*{column}"):
        read_errors(root)


def test_a_duplicate_row_is_refused(root):
    report = pd.read_csv(root / REPORT)
    pd.concat([report, report.iloc[:1]]).to_csv(root / REPORT, index=False)
    with pytest.raises(InputError, match=rf"forecast_error\.csv, row {len(report) + 1}.*duplicate"):
        read_errors(root)
