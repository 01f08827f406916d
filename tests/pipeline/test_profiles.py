"""A profile reaches DVC through the shell as what it says."""

import shlex
import shutil
import subprocess
from pathlib import Path

import pytest
from dvc.utils.hydra import apply_overrides
from ruamel.yaml import YAML

from rallygap.pipeline.params import load_params, read_yaml
from rallygap.pipeline.profiles import flags, merged, profile_flags
from rallygap.pipeline.runtime.errors import InputError

ROOT = Path(__file__).parents[2]


def overridden(path, words):
    """What `dvc exp run` makes of a parameter file, its flags passed through a shell."""
    script = f"printf '%s\\n' $(echo {shlex.quote(' '.join(words))})"
    arrived = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    apply_overrides(path, [word for word in arrived.stdout.splitlines() if word != "-S"])
    return read_yaml(path)


@pytest.mark.parametrize(
    "name", [path.stem for path in (ROOT / "experiments" / "profiles").glob("*.yaml")]
)
def test_every_profile_reaches_dvc_as_it_is_written(name, tmp_path):
    shutil.copy(ROOT / "params.yaml", tmp_path)
    profile = read_yaml(ROOT / "experiments" / "profiles" / f"{name}.yaml")
    expected = merged(read_yaml(ROOT / "params.yaml"), profile)
    assert overridden(tmp_path / "params.yaml", profile_flags(ROOT, name)) == expected
    load_params(tmp_path / "params.yaml")


AWKWARD = ["07", "true", "null", "1e3", "a'b", "é", "x:y/z.yaml", "$HOME", "{a}", "a,b", "*", ""]


def test_awkward_values_reach_dvc_as_they_are(tmp_path):
    before = {"a": {"words": ["x"], "number": 1.0, "gone": 1}, "b": {"c": {"d": 1}}}
    after = {"a": {"words": AWKWARD, "number": 1e-9, "new": None}, "b": {"c": {"e": {"f": False}}}}
    YAML().dump(before, tmp_path / "params.yaml")
    assert overridden(tmp_path / "params.yaml", flags(before, after)) == after


@pytest.mark.parametrize("value", ["two words", "back\\slash", 'a "quote"', "two\nlines"])
def test_what_a_shell_would_spoil_is_refused(value):
    with pytest.raises(InputError, match=r"a\.b: holds white space, a quote or a backslash"):
        flags({"a": {"b": ""}}, {"a": {"b": value}})


def test_a_profile_that_is_not_there_or_does_not_fit_is_refused_by_its_name(tmp_path):
    with pytest.raises(InputError, match=r"smok\.yaml: .*did you mean smoke\?"):
        profile_flags(ROOT, "smok")
    shutil.copy(ROOT / "params.yaml", tmp_path)
    (tmp_path / "experiments" / "profiles").mkdir(parents=True)
    (tmp_path / "experiments" / "profiles" / "mine.yaml").write_text("segment: {noize: 1}")
    with pytest.raises(InputError, match=r"mine\.yaml, segment\.noize: .*did you mean noise\?"):
        profile_flags(tmp_path, "mine")
