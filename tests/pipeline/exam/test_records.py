"""The file of exam records."""

import pytest

from pipeline.exam.records import read_records, write_records
from pipeline.runtime.errors import InputError
from tests.models.exam.example_records import example_exam, record


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
        (None, "there is no such file; run `make exam`"),
        ("", "has no record; run `make exam`"),
        ("{}\n", r"row 1, name: Field required; run `make exam`"),
        ("no json\n", "row 1: Invalid JSON"),
    ],
)
def test_a_damaged_file_is_one_error(tmp_path, content, problem):
    path = tmp_path / "records.jsonl"
    if content is not None:
        path.write_text(content)

    with pytest.raises(InputError, match=problem):
        read_records(path)
