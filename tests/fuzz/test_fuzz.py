"""Readers meet damaged and hostile files: balls or numbers come out, or one clear error does."""

import pickle
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rallygap.pipeline.params import Params, check_params, read_yaml
from rallygap.pipeline.runtime.errors import InputError
from tests.fuzz.hostile import Trap
from tests.fuzz.readers import READERS, ROOT, Reader
from tests.fuzz.trial import fault, limited_memory

NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
IN_PLACE_OF_NUMBERS = [
    b"nan", b".nan", b"Infinity", b"-inf", b"1e400", b"-1e308", b"1e30", b"-1", b"0", b"-0.0",
    b"9" * 400, b"9" * 5000, b"0x7f", b"1_000", b"null", b"true", b"~", b'""', b'"7"', b"[]", b"{}",
    b"[1, 2]", b"7 7", b"", b"\xff", b"\x00", b"*a", b"&a 1", b"!!float x", b"2026-99-99",
]  # fmt: skip
# As binary formats keep lengths and offsets.
WORDS = [size.to_bytes(8, "little") for size in (0, 1, 2**31, 2**32 - 1, 2**62, 2**64 - 1)]

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3)
    ),
    max_leaves=5,
)


@st.composite
def damaged(draw, whole):
    """The bytes of a file with a part that is replaced, lost, repeated, or a number no more."""
    numbers = list(NUMBER.finditer(whole))
    if numbers and draw(st.booleans()):
        first, last = draw(st.sampled_from(numbers)).span()
        return whole[:first] + draw(st.sampled_from(IN_PLACE_OF_NUMBERS)) + whole[last:]
    first, last = sorted(draw(st.integers(0, len(whole))) for _ in range(2))
    put = draw(st.binary(max_size=16) | st.sampled_from(WORDS))
    return draw(
        st.sampled_from(
            [
                whole[:first] + put + whole[first + len(put) :],
                whole[:first] + put + whole[first:],
                whole[:first] + whole[last:],
                whole[:last] + whole[first:],
                whole[:last],
            ]
        )
    )


@pytest.mark.slow
@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader.name)
def test_no_hostile_file_is_a_fault(reader, tmp_path):
    path = reader.write(tmp_path)
    with limited_memory():
        for content in reader.hostile:
            path.write_bytes(content)
            assert fault(reader, tmp_path, path) is None, content[:60]


@pytest.mark.parametrize(
    "examples", [5, pytest.param(60, marks=pytest.mark.slow)], ids=["few", "many"]
)
@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader.name)
def test_the_file_itself_is_read_and_no_damage_is_a_fault(reader, tmp_path, examples):
    path = reader.write(tmp_path)
    assert fault(reader, tmp_path, path) is None
    refused = reader.read(tmp_path)
    assert not (isinstance(refused, int) and refused)
    whole = path.read_bytes()

    @given(content=damaged(whole))
    @settings(max_examples=examples)
    def damage(content):
        path.write_bytes(content)
        assert fault(reader, tmp_path, path) is None

    with limited_memory():
        damage()


def test_what_works_too_long_or_runs_code_is_a_fault(tmp_path, monkeypatch):
    monkeypatch.setattr("tests.fuzz.trial.LONGEST", 0.2)

    def swallowed(_):
        try:
            while True:
                pass
        except Exception as error:
            raise InputError("file", f"is none: {error}") from None

    def unpickled(_):
        pickle.loads(pickle.dumps(Trap()))
        raise InputError("file", "is none")

    def taken(_):
        return len(b"0" * 1_000_000_000) * 0

    for read, wrong in ((swallowed, "still reading"), (unpickled, "ran code"), (taken, "took")):
        reader = Reader("made up", lambda folder: folder / "file", read, [])
        assert wrong in fault(reader, tmp_path, tmp_path / "file")


def places(content, above=()):
    """Every place in nested dictionaries."""
    for key, value in content.items():
        yield (*above, key)
        if isinstance(value, dict):
            yield from places(value, (*above, key))


PARAMS = read_yaml(ROOT / "params.yaml")
PLACES = list(places(PARAMS))


def replaced(content, place, value):
    first, *rest = place
    return {**content, first: replaced(content[first], rest, value) if rest else value}


@pytest.mark.slow
@given(place=st.sampled_from(PLACES), value=VALUES)
@settings(max_examples=200)
def test_any_value_in_any_place_of_the_parameters_is_taken_or_refused_by_name(place, value):
    try:
        checked = check_params(replaced(PARAMS, place, value), ROOT / "params.yaml")
    except InputError as error:
        assert str(error).startswith(f"{ROOT / 'params.yaml'}")
        assert place[0] in str(error) or "Unicode" in str(error) or "JSON" in str(error)
    else:
        assert isinstance(checked, Params)
