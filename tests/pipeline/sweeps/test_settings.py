"""Settings of a sweep are read from a file, or refused with the field's name."""

import pytest

from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sweeps.settings import Sweep
from tests.pipeline.sweeps.small_sweeps import HEADS, RATE, ROOT, SETTINGS, small_sweep

HIDDEN = "train_predictor.training.hidden_spin"


@pytest.mark.parametrize("name", ["predictor", "policy", "quick"])
def test_the_first_trial_of_a_committed_sweep_has_the_parameters_of_params_yaml(name):
    sweep = Sweep(ROOT, name)
    defaults = sweep.defaults()
    assert defaults is not None
    assert sweep.trial_params(defaults) == sweep.trial_params({})


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"space": {"train_predictor.training.rate": {"low": 1, "high": 2}}}, "is no parameter"),
        ({"space": {"segment.noise": {"low": 0.1, "high": 0.2}}}, "cannot be searched"),
        ({"space": {HIDDEN: {"low": 0.1, "high": 0.2}}}, "cannot be searched"),
        ({"space": {RATE: {"low": 0.1, "high": 7.5}}}, "less than or equal to 1, not 7.5"),
        ({"space": {RATE: {"low": 0.2, "high": 0.1}}}, "give a low limit"),
        ({"space": {RATE: {"low": 0.2}}}, "Field required"),
        ({"space": {RATE: {"low": 0.0, "high": 0.1, "log": True}}}, "above zero with log"),
        ({"space": {RATE: [0.1]}}, "at least 2 items"),
        ({"in_trials": {"train_predictor.training.epoch": 3}}, "is no parameter"),
    ],
)
def test_invalid_settings_are_refused(tmp_path, changes, says):
    with pytest.raises(InputError, match=r"tiny\.yaml") as refused:
        small_sweep(tmp_path, **changes)
    assert says in str(refused.value)


def test_an_unknown_sweep_is_refused_with_the_known_names(tmp_path):
    small_sweep(tmp_path)
    with pytest.raises(InputError, match="there are: tiny"):
        Sweep(tmp_path, "wide")


def test_other_data_or_another_space_make_another_study_but_more_trials_do_not(tmp_path):
    study = small_sweep(tmp_path).study
    assert small_sweep(tmp_path, trials=100).study == study
    space = {**SETTINGS["space"], HEADS: [2, 4]}
    assert small_sweep(tmp_path, space=space).study != study
    sweep = small_sweep(tmp_path)
    (tmp_path / "data.txt").write_text("other shots")
    assert sweep.study != study
