"""What a disk has damaged in DVC's cache is found, and made anew."""

import subprocess
import sys

import pytest

from pipeline.experiments.cache_repair import mend
from pipeline.runtime.errors import InputError

DVC_YAML = """
stages:
  write:
    cmd: mkdir folder && echo one > folder/a && echo two > folder/b && echo three > file
    outs: [folder, file]
"""


@pytest.fixture
def repository(tmp_path):
    """A repository of DVC with outputs in its cache."""
    (tmp_path / "dvc.yaml").write_text(DVC_YAML)
    dvc(tmp_path, "init", "--no-scm", "--quiet")
    dvc(tmp_path, "repro", "--quiet")
    return tmp_path


def dvc(folder, *words):
    subprocess.run([sys.executable, "-m", "dvc", *words], cwd=folder, check=True)


def cached(repository, content):
    """The file of the cache that holds a content."""
    files = (repository / ".dvc" / "cache" / "files" / "md5").rglob("*")
    (found,) = (path for path in files if path.is_file() and path.read_bytes() == content)
    return found


def damage(path):
    path.chmod(0o644)
    path.write_bytes(b"tw0\n")
    path.chmod(0o444)


def test_what_is_whole_stays(repository):
    assert mend(repository) == []


def test_damage_is_removed_with_its_copies_and_made_anew(repository):
    entry = cached(repository, b"two\n")
    damage(entry)
    (repository / "folder" / "b").unlink()
    dvc(repository, "checkout", "--quiet")
    assert (repository / "folder" / "b").read_bytes() == b"tw0\n"  # DVC has put it there
    assert mend(repository) == [entry, repository / "folder" / "b"]
    dvc(repository, "repro", "--quiet")
    assert (repository / "folder" / "b").read_bytes() == b"two\n"
    assert mend(repository) == []


def test_a_damaged_list_of_a_folder_is_found(repository):
    (entry,) = (repository / ".dvc" / "cache" / "files" / "md5").rglob("*.dir")
    damage(entry)
    assert mend(repository) == [entry]
    dvc(repository, "repro", "--quiet")
    assert mend(repository) == []
    assert entry.exists()


@pytest.mark.parametrize(
    "lock", ["7", "[]", "{}", "stages: 7", "stages: {write: {outs: [7]}}",
             "stages: {write: {outs: [{path: /}]}}", "stages: {write: {outs: [{path: a/../..}]}}",
             "stages: {write: {outs: [{path: .}]}}", "stages: {write: {outs: [{}]}}"]
)  # fmt: skip
def test_with_a_broken_list_of_outputs_nothing_is_removed(repository, lock):
    entry = cached(repository, b"two\n")
    damage(entry)
    (repository / "dvc.lock").write_text(lock)
    with pytest.raises(InputError, match=r"dvc\.lock"):
        mend(repository)
    assert entry.exists()


def test_a_lock_of_which_a_kill_left_half_is_removed(repository):
    lock = repository / ".dvc" / "tmp" / "rwlock"
    assert lock.exists()
    lock.write_text('{"read": {')
    with pytest.raises(subprocess.CalledProcessError):
        dvc(repository, "repro", "--quiet", "--force")
    assert mend(repository) == [lock]
    dvc(repository, "repro", "--quiet", "--force")


def test_a_folder_that_is_no_repository_is_one_error(tmp_path):
    with pytest.raises(InputError, match="is no repository that DVC can open"):
        mend(tmp_path)


def test_there_is_nothing_to_mend_before_the_first_run(tmp_path):
    dvc(tmp_path, "init", "--no-scm", "--quiet")
    assert mend(tmp_path) == []
