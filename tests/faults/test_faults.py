"""Whatever kills or disturbs a stage, `dvc repro` then ends as if nothing had happened."""

import pytest

from tests.faults.breakages import FAULTS, suffer
from tests.faults.disks import may_mount
from tests.faults.kills import kill_stage, kills_a_stage
from tests.faults.repository import stages, undisturbed

pytestmark = pytest.mark.faults


@pytest.fixture(scope="module")
def repository(tmp_path_factory):
    return undisturbed(tmp_path_factory.mktemp("faults"))


@pytest.mark.parametrize("stage", stages())
def test_a_killed_stage_ends_as_an_undisturbed_one(repository, stage):
    among = kills_a_stage()
    for number in range(1, among + 1):
        *late, last = kill_stage(repository, stage, number, among)
        assert last.hit
        for kill in [*late, last]:
            assert kill.same_hashes, kill.differences
            assert kill.half_written == 0


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: f"{fault.name}, {fault.stage}")
def test_a_fault_is_borne_or_named_and_then_forgotten(repository, fault):
    if fault.needs_root and not may_mount():
        pytest.skip("only root may mount a disk")
    suffered = suffer(repository, fault)
    assert suffered.same_hashes, suffered.differences
    assert suffered.as_expected, suffered
