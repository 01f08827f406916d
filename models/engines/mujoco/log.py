"""MuJoCo's warnings, which it otherwise prints and writes to a file in the working directory."""

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco


@contextmanager
def collected_warnings() -> Iterator[list[str]]:
    """Collect the warnings of a block as sentences."""
    before = mujoco.get_mju_user_warning()
    collected: list[str] = []
    mujoco.set_mju_user_warning(collected.append)
    try:
        yield collected
    finally:
        mujoco.set_mju_user_warning(before)
