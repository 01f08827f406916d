"""What a stage leaves beside its outputs survives the temporary copies that DVC removes."""

import shutil
import threading

import pytest
import yaml

from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.provenance import provenance
from rallygap.pipeline.runtime.scratch import keep_timings, kept_timings, scratch_kept
from rallygap.pipeline.runtime.stage_run import StageRun

FINGERPRINT, OTHER = "f" * 64, "0" * 64


@pytest.fixture
def home(tmp_path, monkeypatch):
    """The repository, as DVC names it to a stage in a temporary copy."""
    monkeypatch.setenv("DVC_ROOT", str(tmp_path / "home"))
    (tmp_path / "home").mkdir()
    return tmp_path / "home"


def copied_run(tmp_path, monkeypatch, name, fingerprint=FINGERPRINT):
    """The run of a stage in a new copy of the repository."""
    (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path / name)
    return StageRun("segment", tmp_path / name, None, fingerprint)


def leave_and_fail(run):
    with pytest.raises(RuntimeError), scratch_kept("segment", run.fingerprint):
        run.scratch("net").mkdir(parents=True)
        (run.scratch("net") / "last").write_text(f"epoch of {run.fingerprint}")
        raise RuntimeError


def test_a_killed_stage_goes_on_in_the_next_copy_and_leaves_only_the_scratch_of_others(
    home, tmp_path, monkeypatch
):
    leave_and_fail(copied_run(tmp_path, monkeypatch, "other", OTHER))
    leave_and_fail(copied_run(tmp_path, monkeypatch, "first"))
    shutil.rmtree(tmp_path / "first")
    run = copied_run(tmp_path, monkeypatch, "second")
    with scratch_kept("segment", FINGERPRINT):
        assert (run.scratch("net") / "last").read_text() == f"epoch of {FINGERPRINT}"
        run.clear_scratch()
    assert [path.read_text() for path in home.rglob("last")] == [f"epoch of {OTHER}"]


def test_copies_that_are_at_the_same_take_turns(home, tmp_path, monkeypatch):
    copied_run(tmp_path, monkeypatch, "first")
    entered = threading.Event()

    def other():
        with scratch_kept("segment", FINGERPRINT):
            entered.set()

    waiting = threading.Thread(target=other)
    with scratch_kept("segment", FINGERPRINT):
        waiting.start()
        assert not entered.wait(0.3)
    waiting.join()
    assert entered.is_set()


def test_timings_are_those_of_a_run_with_the_present_inputs_or_one_error(home):
    stage = {"cmd": "a", "deps": [], "params": ["gap"]}
    (home / "dvc.yaml").write_text(yaml.safe_dump({"stages": {"segment": stage}}))
    (home / "params.yaml").write_text("gap: 0.1\n")
    present = provenance(home, "segment").fingerprint
    keep_timings("segment", OTHER, {"net": {"training_s": 5}})
    assert kept_timings(home, "segment") == {}
    keep_timings("segment", present, {"net": {"training_s": 3}})
    assert kept_timings(home, "segment") == {"net": {"training_s": 3}}
    for content in (7, [0], {"net": "long"}, {"net": {"training_s": None}}):
        keep_timings("segment", present, content)
        with pytest.raises(InputError, match=present[:12]):
            kept_timings(home, "segment")
