"""Trained policies as files: they come back bit for bit, or one error names the file."""

import json

import numpy as np
import pytest
from safetensors.numpy import save

from rallygap.pipeline.params import PolicyGroupSettings
from rallygap.pipeline.policies.storage import DESCRIPTION, WEIGHTS, load_policies, load_policy
from rallygap.pipeline.runtime.errors import InputError
from tests.models.policy.schooling import BRIEF, GOALS, drawn_policy, same
from tests.pipeline.trained_policies import description, save_drawn


def test_a_policy_comes_back_as_it_was_saved(tmp_path):
    policy, described = save_drawn(tmp_path)

    loaded, read = load_policy(tmp_path / "small-imperfect_c-115ms-0")

    assert same(loaded, policy)
    assert read == described


def test_a_group_is_all_policies_of_its_name_and_no_others(tmp_path):
    for changes in ({"repeat": 1}, {"repeat": 0}, {"group": "small_too"}, {"group": "too_small"}):
        save_drawn(tmp_path, seed=changes.get("repeat", 7), **changes)

    loaded = load_policies(tmp_path, "small")

    assert [described.repeat for _, described in loaded] == [0, 1]
    assert same(loaded[0][0], drawn_policy(0)) and same(loaded[1][0], drawn_policy(1))


def test_a_group_without_policies_is_an_error_that_says_where_groups_are(tmp_path):
    save_drawn(tmp_path)

    with pytest.raises(InputError, match=r"no policy of the group smal; see train_policy\.groups"):
        load_policies(tmp_path, "smal")


def described_with(**changes):
    return json.dumps({**description().model_dump(mode="json"), **changes}).encode()


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        (WEIGHTS, None, r"there is no such file; run the stage train_policy"),
        (WEIGHTS, b"", "is not a file of weights"),
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
    plain = {
        "simulators": ["imperfect_a", "imperfect_b"],
        "horizons_ms": [(115, 120, 125), (170, 175, 180)],
        "repeats": 2,
        "observation": "strict",
        "goals": GOALS,
        "learning": BRIEF,
    }
    PolicyGroupSettings(**plain)

    with pytest.raises(ValueError, match="must differ"):
        PolicyGroupSettings(**{**plain, **changes})
