"""Kill every stage, fill disks and damage files; an hour, as root, since it mounts disks.

All of it strikes a copy of the repository with the profile `smoke`: docs/reliability.md.
"""

import tempfile
from dataclasses import asdict
from pathlib import Path

import pandas as pd

from experiments.reliability.breakages import FAULTS, suffer
from experiments.reliability.disks import may_mount
from experiments.reliability.kills import kill_stage, kills_a_stage
from experiments.reliability.repository import stages, undisturbed
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.progress import progress
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage


def reliability(run: StageRun) -> None:
    """Write what came of every kill and of every fault.

    Raises:
        InputError: this process may not mount disks.
    """
    if not may_mount():
        raise InputError("reliability", "mounts disks, which only root may: run it as root")
    among = kills_a_stage()
    drawn = [(stage, number) for stage in stages() for number in range(1, among + 1)]
    with tempfile.TemporaryDirectory(prefix="rallygap-reliability.") as folder:
        repository = undisturbed(Path(folder))
        kills = [
            kill
            for stage, number in progress(drawn, "kills", len(drawn))
            for kill in kill_stage(repository, stage, number, among)
        ]
        faults = [suffer(repository, fault) for fault in progress(FAULTS, "faults", len(FAULTS))]
    run.publish(
        {"kills": pd.DataFrame(map(asdict, kills)), "faults": pd.DataFrame(map(asdict, faults))}
    )


if __name__ == "__main__":
    run_stage(reliability)
