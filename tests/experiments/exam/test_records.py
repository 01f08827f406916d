"""The file of exam records."""

from pathlib import Path

import pandas as pd
import pytest

from experiments.exam.records import RECORDS, read_records, write_records
from experiments.exam.scoring.rates import rates
from experiments.report.answers import methods_of
from rallygap.pipeline.runtime.errors import InputError
from tests.experiments.exam.example_records import example_exam, record

REPOSITORY = Path(__file__).parents[3]


def test_the_committed_records_give_the_committed_rates():
    records = read_records(REPOSITORY / RECORDS)
    committed = pd.read_csv(REPOSITORY / "reports/exam/rates.csv").set_index("rate")
    for method in methods_of(records):
        found = pd.Series(rates(records, method), dtype=float)
        pd.testing.assert_series_equal(committed[method], found, rtol=1e-5, check_names=False)


def test_written_records_are_read_again_with_six_digits(tmp_path):
    records = example_exam(every=60)
    path = tmp_path / "records.jsonl"
    write_records(path, records)

    assert read_records(path) == records
    assert len(path.read_text().splitlines()) == len(records)
    assert record(noise=0.00300000049).noise == 0.003


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (None, "there is no such file; run `python -m experiments.stages.exam`"),
        ("", "has no record; run `python -m experiments.stages.exam`"),
        ("{}\n", r"row 1, name: Field required; run `python -m experiments.stages.exam`"),
        ("no json\n", "row 1: Invalid JSON"),
    ],
)
def test_a_damaged_file_is_one_error(tmp_path, content, problem):
    path = tmp_path / "records.jsonl"
    if content is not None:
        path.write_text(content)

    with pytest.raises(InputError, match=problem):
        read_records(path)
