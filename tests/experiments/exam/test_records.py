"""The file of exam records."""

import pytest

from experiments.exam.records import read_records, write_records
from rallygap.pipeline.runtime.errors import InputError
from tests.experiments.exam.example_records import COMMITTED, committed, record


def test_records_that_are_read_are_written_to_the_same_bytes(tmp_path):
    write_records(tmp_path / "records.jsonl", committed())
    assert (tmp_path / "records.jsonl").read_bytes() == COMMITTED.read_bytes()
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
