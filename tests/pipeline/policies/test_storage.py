"""Trained policies as files: they come back bit for bit, or one error names the file."""

import json

import numpy as np
import pytest
from safetensors.numpy import save

from rallygap.pipeline.params import PolicyGroupSettings
from rallygap.pipeline.policies.storage import DESCRIPTION, WEIGHTS, load_policies, load_policy
from rallygap.pipeline.runtime.errors import InputError
from tests.models.policy.schooling import drawn_policy, same
from tests.pipeline.measured_shots import params
from tests.pipeline.trained_policies import description, save_drawn


def test_policies_of_a_group_and_no_others_come_back_as_they_were_saved(tmp_path):
    for repeat in (1, 0):
        save_drawn(tmp_path, seed=repeat, repeat=repeat)
    for group in ("small_too", "too_small"):
        save_drawn(tmp_path, group=group)
    for (loaded, described), repeat in zip(load_policies(tmp_path, "small"), (0, 1), strict=True):
        assert same(loaded, drawn_policy(repeat))
        assert described == description(repeat=repeat)


def described_with(**changes):
    return json.dumps({**description().model_dump(mode="json"), **changes}).encode()


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        (WEIGHTS, None, r"there is no such file; run the stage train_policy"),
        (WEIGHTS, save(drawn_policy().to_arrays())[:-9], "is not a file of weights"),
        (WEIGHTS, save({"a": np.zeros(3)}), "is not a file of weights: no policy has"),
        (DESCRIPTION, None, "there is no such file"),
        (DESCRIPTION, b"{", "is not JSON"),
        (DESCRIPTION, described_with(horizons=[3, 2, 1]), "horizons.* `dvc repro -f train_policy`"),
        (DESCRIPTION, described_with(effects={"wand": {}}), "effects.*wand.*train_policy`"),
        (DESCRIPTION, described_with(more=1), "more.*train_policy`"),
    ],
)
def test_a_broken_file_is_one_error_that_names_it(tmp_path, name, content, message):
    _, described = save_drawn(tmp_path)
    path = tmp_path / described.name / name
    path.unlink()
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=message) as error:
        load_policy(path.parent)
    assert str(error.value).startswith(str(path))


@pytest.mark.parametrize(
    "changes",
    [
        {"simulators": ["imperfect_a", "imperfect_a"]},
        {"horizons_ms": [(115, 120, 125), (115, 130, 145)]},
    ],
)
def test_two_policies_that_would_share_a_name_are_refused(changes):
    plain = params().train_policy.groups["sim2sim"].model_dump()
    with pytest.raises(ValueError, match="must differ"):
        PolicyGroupSettings(**{**plain, **changes})
