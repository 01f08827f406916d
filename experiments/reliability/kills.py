"""Stages killed by SIGKILL, DVC and all their workers with them, at moments that a seed draws."""

import os
import signal
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import psutil

from experiments.reliability.repository import Repository, awaited_stage, stages

SEED = 7
IN_ALL = 50  # kills that must hit, at least
A_STAGE = 4  # of them, at least
ATTEMPTS = 6  # at one kill, where the stage has ended before its moment
EARLIER = 0.9  # by which the moments of each further attempt are


@dataclass(frozen=True)
class Kill:
    """One kill of a stage and what came of it."""

    stage: str
    number: int  # counted from 1 in each stage
    share: float  # of the stage's duration in the undisturbed run, at which it was killed
    seconds: float  # the same since its start
    hit: bool  # whether it still ran
    files_left: int  # among its outputs
    half_written: int  # files that stood under their name and were not whole
    repaired: str  # a file of DVC's that was damaged, repaired as docs/reliability.md says
    same_hashes: bool  # whether `dvc repro` then ended with the undisturbed run's bytes and lock
    differences: str  # the files that say otherwise


def kills_a_stage() -> int:
    """How many kills must hit each stage."""
    return max(A_STAGE, -(-IN_ALL // len(stages())))


def kill_stage(repository: Repository, stage: str, number: int, among: int) -> Iterator[Kill]:
    """Kill a stage until one kill hits it; yield that one and those that came too late.

    The moment is drawn from the ``number``th of ``among`` equal parts of the stage's duration, and
    earlier where the stage ran faster this time.
    """
    draws = np.random.default_rng([SEED, stages().index(stage), number])
    for attempt in range(ATTEMPTS):
        share = (number - 1 + draws.random()) / among * EARLIER**attempt
        kill = _killed(repository, stage, number, share)
        yield kill
        if kill.hit:
            return


def _killed(repository: Repository, stage: str, number: int, share: float) -> Kill:
    with repository.without(stage):
        hit, seconds = killed_group(repository, stage, share * repository.seconds[stage])
        left, half = repository.left_by(stage), repository.half_written()
        ended, repaired = repository.recover()
        differences = repository.differences()
        if ended.status:
            differences = [ended.message, *differences]
    return Kill(
        stage=stage,
        number=number,
        share=round(share, 3),
        seconds=round(seconds, 2),
        hit=hit,
        files_left=len(left),
        half_written=len(half),
        repaired=repaired,
        same_hashes=not differences,
        differences="; ".join(differences),
    )


def killed_group(repository: Repository, stage: str, after: float) -> tuple[bool, float]:
    """Run a stage and kill all its process group, so many seconds after it began.

    Returns:
        Whether the stage still ran, and how many seconds it had.
    """
    dvc = repository.start("dvc", "repro", stage)
    running = awaited_stage(dvc)
    started = time.monotonic()
    assert running is not None and running[0] == stage, repository.printed()
    time.sleep(after)
    # What is stopped cannot end between the question and the kill.
    os.killpg(dvc.pid, signal.SIGSTOP)
    hit, seconds = _halted(running[1]), time.monotonic() - started
    os.killpg(dvc.pid, signal.SIGKILL)
    dvc.wait()
    return hit, seconds


def _halted(process: psutil.Process) -> bool:
    """Wait until a stopped process has ended; False where it had ended before."""
    try:
        while (status := process.status()) != psutil.STATUS_STOPPED:
            if status in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD):
                return False
            time.sleep(0.001)
    except psutil.NoSuchProcess:
        return False
    return True
