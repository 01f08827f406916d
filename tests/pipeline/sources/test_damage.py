"""Damaged files: whatever happens to their bytes, balls come out or one clear error does."""

import tempfile
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rallygap.pipeline.io.schemas import LAUNCHES, RECORDINGS, checked
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.sources.made_up import WRITERS, read, write_csv, write_spindoe

BYTES = st.binary(min_size=1, max_size=4) | st.sampled_from(
    [b"\x00", b"-", b"e", b"9", b",", b"\n"]
)
DAMAGE = st.lists(st.tuples(st.floats(0, 1), BYTES), min_size=1, max_size=4)


YAML = "rate: 143\nkind: cannon\nframe:\n  offset: [0, 1.37, -0.76]\n"


def write_described_csv(folder: Path) -> Path:
    return write_csv(folder, settings=YAML)


SIDE_FILES = {"spindoe/index.csv": write_spindoe, "csv/source.yaml": write_described_csv}


def write(what: str, folder: Path) -> tuple[str, Path]:
    """Write a source and return its name and the file to damage."""
    source = what.split("/")[0]
    data_file = {**WRITERS, **SIDE_FILES}[what](folder)
    return source, data_file if what in WRITERS else folder / what


def damaged(content: bytes, damage) -> bytes:
    """Overwrite ``content`` at shares of its length."""
    result = bytearray(content)
    for share, piece in damage:
        start = int(share * len(content))
        result[start : start + len(piece)] = piece
    return bytes(result)


@pytest.mark.parametrize("source", [*WRITERS, *SIDE_FILES])
@given(damage=DAMAGE, kept=st.floats(0, 1) | st.just(1.0))
@example(damage=[(0.5, b"")], kept=1.0)
@settings(max_examples=40)
def test_damaged_files_give_balls_or_an_input_error(source, damage, kept):
    with tempfile.TemporaryDirectory() as folder:
        source, path = write(source, Path(folder))
        content = damaged(path.read_bytes(), damage)
        path.write_bytes(content[: int(kept * len(content))])
        try:
            gathered = read(Path(folder), source)
        except InputError as error:
            assert path.name in str(error) or source in str(error)
            return
    checked(gathered.recordings, RECORDINGS)
    checked(gathered.launches, LAUNCHES)
    (record,) = gathered.manifest.sources.values()
    refused = sum(group.count for group in record.rows_refused.values())
    assert record.rows_read - record.rows_kept == refused
