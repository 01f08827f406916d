"""What a sweep may try is read from a file, or refused by name."""

import pytest

from pipeline.runtime.errors import InputError
from pipeline.sweeps.plan import load_plan, nested
from tests.pipeline.sweeps.made_up import HEADS, RATE, ROOT, TINY, plan, write_repository


@pytest.mark.parametrize("name", ["predictor", "policy", "quick"])
def test_the_sweeps_of_the_repository_begin_with_its_parameters(name):
    swept = load_plan(ROOT, name)
    defaults = swept.defaults()
    assert defaults is not None
    assert swept.trial_params(defaults) == swept.trial_params({})


def test_trials_differ_from_the_parameters_in_what_is_tried_and_in_what_makes_them_short(tmp_path):
    params = plan(tmp_path).trial_params({RATE: 0.02, HEADS: 8})
    training = params.train_predictor.training
    assert (training.learning_rate, training.epochs) == (0.02, 3)
    assert params.train_predictor.networks["transformer"].heads == 8
    assert (
        training.batch
        == load_plan(ROOT, "predictor").params["train_predictor"]["training"]["batch"]
    )


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"space": {"train_predictor.training.rate": {"low": 1, "high": 2}}}, "is no parameter"),
        ({"space": {"segment.noise": {"low": 0.1, "high": 0.2}}}, "not the sweep's to find"),
        (
            {"space": {"train_predictor.training.hidden_spin": {"low": 0.1, "high": 0.2}}},
            "not the sweep's to find",
        ),
        ({"space": {RATE: {"low": 0.1, "high": 7.5}}}, "less than or equal to 1, not 7.5"),
        ({"space": {RATE: {"low": 0.2, "high": 0.1}}}, "give a low limit"),
        ({"space": {RATE: {"low": 0.0, "high": 0.1, "log": True}}}, "above zero where log"),
        ({"space": {RATE: {"choices": [0.1]}}}, "at least 2 items"),
        ({"space": {}}, "at least 1 item"),
        ({"in_trials": {"train_predictor.training.epoch": 3}}, "is no parameter"),
        ({"network": "lstm"}, "is no parameter"),
        ({"trains": "robot"}, "does not match any of the expected tags"),
        ({"trails": 3}, "Extra inputs are not permitted"),
    ],
)
def test_what_cannot_be_swept_is_refused_by_name(tmp_path, changes, says):
    with pytest.raises(InputError, match=r"tiny\.yaml") as refused:
        plan(tmp_path, **changes)
    assert says in str(refused.value)


def test_a_sweep_that_is_not_there_is_refused_with_those_that_are(tmp_path):
    write_repository(tmp_path, "narrow")
    with pytest.raises(InputError, match="there are: narrow"):
        load_plan(tmp_path, "wide")


def test_other_data_and_another_space_make_another_study_more_trials_do_not(tmp_path):
    study = plan(tmp_path).study
    assert plan(tmp_path, trials=100).study == study
    space = {**TINY["space"], HEADS: {"choices": [2, 4]}}
    assert plan(tmp_path, space=space).study != study
    same = plan(tmp_path)
    (tmp_path / "data.txt").write_text("other balls")
    assert same.study != study


def test_parameters_outside_the_space_are_not_tried(tmp_path):
    assert plan(tmp_path, space={HEADS: {"choices": [2, 8]}}).defaults() is None


def test_dotted_names_become_groups_within_groups():
    assert nested({"a.b.c": 1, "a.b.d": None, "e": 2}) == {"a": {"b": {"c": 1, "d": None}}, "e": 2}
