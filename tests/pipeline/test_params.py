"""params.yaml is typed and bounded; an error names the key."""

import pickle
from pathlib import Path

import pytest

from rallygap.pipeline.params import ParameterError, check_params, load_params, read_yaml
from rallygap.pipeline.runtime.errors import InputError

ROOT = Path(__file__).parents[2]
PARAMS = ROOT / "params.yaml"
UNLIKE_JSON = ["2001-09-09: 1", "seed: 2001-99-99", "seed: &a [*a]", "? [a, b]\n: 1"]


def complaint(key, value):
    """What is said of params.yaml with one dotted key set."""
    content = group = read_yaml(PARAMS)
    *above, last = key.split(".")
    for part in above:
        group = group[part]
    group[last] = value
    with pytest.raises(InputError) as caught:
        check_params(content, Path("params.yaml"))
    return str(caught.value)


def test_every_parameter_is_written_in_params_yaml():
    assert load_params(PARAMS).model_dump(mode="json") == read_yaml(PARAMS)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("segmnt", {}, "params.yaml, segmnt: is an unknown key; did you mean segment?"),
        ("evaluate_predictor.predictors.x", {"kind": "physics"}, "x.simulator: is missing"),
        ("seed", "3", 'seed: input should be a valid integer, not "3"'),
        ("segment.longest_gap", 7, "segment.longest_gap: input should be less than or equal to 1"),
        ("segment", None, "segment: input should be an object, not null"),
        ("evaluate_predictor.predictors", {"A b": {}}, "predictors.A b"),
        ("evaluate_predictor.window_every_ms", 7, "should be a multiple of 5, not 7"),
        ("train_predictor.networks.tae.kind", "lstm", "networks.tae: "),
        ("train_predictor.networks.transformer.heads", 5, "networks.transformer: value error, 5"),
        ("sim2real.learned", ["tae", "tae"], "give each name once"),
    ],
)
def test_an_error_names_the_key(key, value, message):
    assert message in complaint(key, value)


def test_an_unknown_key_is_compared_with_those_of_its_own_kind():
    network = {"kind": "gru_tae", "recurrent": 8, "latnt": 8, "decoded": 8, "uniform_motion": True}
    message = complaint("train_predictor.networks.tae", network).splitlines()
    assert "networks.tae.latent: is missing" in message[0]
    assert "networks.tae.latnt: is an unknown key; did you mean latent?" in message[1]


def test_an_error_comes_whole_out_of_a_worker():
    error = InputError("balls.csv", "is not a number", row=3, field="px")
    for one in (error, ParameterError([error, InputError("params.yaml", "?")])):
        again = pickle.loads(pickle.dumps(one))
        assert (type(again), str(again), vars(again)) == (type(one), str(one), vars(one))


@pytest.mark.parametrize("text", ["", "- 1", "a: b: c", "seed: 1\nseed: 2", "\x00", *UNLIKE_JSON])
def test_a_file_that_holds_no_parameters_is_refused(tmp_path, text):
    path = tmp_path / "params.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=r"params\.yaml"):
        load_params(path)
    path.unlink()
    with pytest.raises(InputError, match="no such file"):
        load_params(path)
