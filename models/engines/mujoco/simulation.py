"""How a scene starts, and what MuJoCo warns of while it is simulated."""

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco


def reset(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Bring a scene to its start: its first keyframe, or its reference configuration."""
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    else:
        mujoco.mj_resetData(model, data)


def initial_data(model: mujoco.MjModel) -> mujoco.MjData:
    """Return a scene at its start, with the poses of all geoms."""
    data = mujoco.MjData(model)
    reset(model, data)
    mujoco.mj_kinematics(model, data)
    return data


@contextmanager
def collected_warnings() -> Iterator[list[str]]:
    """Collect the warnings of a block as sentences.

    MuJoCo otherwise prints them and writes them to a file in the working directory.
    """
    before = mujoco.get_mju_user_warning()
    collected: list[str] = []
    mujoco.set_mju_user_warning(collected.append)
    try:
        yield collected
    finally:
        mujoco.set_mju_user_warning(before)
