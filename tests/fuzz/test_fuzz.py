"""Readers meet damaged and hostile files: balls or numbers come out, or one clear error does."""

import pickle

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rallygap.pipeline.params import Params, check_params, read_yaml
from rallygap.pipeline.runtime.errors import InputError
from tests.fuzz.hostile import Trap
from tests.fuzz.readers import READERS, ROOT, Reader
from tests.fuzz.trial import inputs, outcome, tried

SAMPLE = 40  # mutations a reader, beside every hostile file

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3)
    ),
    max_leaves=5,
)


def faults(found):
    return [(message, content[:60]) for ended, message, content in found if ended == "fault"]


@pytest.mark.slow
@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader.name)
def test_no_hostile_file_and_no_mutation_of_a_sample_is_a_fault(reader):
    assert faults(tried(reader, 1 + len(reader.hostile) + SAMPLE)) == []


@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader.name)
def test_the_file_itself_is_read_and_bytes_put_anywhere_are_no_fault(reader, tmp_path):
    path = reader.write(tmp_path)
    assert outcome(reader, tmp_path, path)[0] == "accepted"
    whole = path.read_bytes()

    @given(place=st.integers(0, len(whole)), put=st.binary(min_size=1, max_size=8))
    @settings(max_examples=5)
    def damage(place, put):
        path.write_bytes(whole[:place] + put + whole[place + len(put) :])
        ended, error_text = outcome(reader, tmp_path, path)
        assert ended != "fault", error_text

    damage()


def test_inputs_follow_from_their_number():
    reader = READERS[0]
    whole = b"t,x,y,z\n0,1,2,3\n0.1,1,2,3\n"
    one, other = (list(inputs(reader, 60, whole)) for _ in range(2))
    assert one == other
    assert len(set(one)) > 50


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

    for read, error_text in (
        (swallowed, "still reading"),
        (unpickled, "ran code"),
        (taken, "took"),
    ):
        reader = Reader("made up", lambda folder: folder / "file", read, [])
        kind, message = outcome(reader, tmp_path, tmp_path / "file")
        assert kind == "fault" and error_text in message


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
