"""The state in which a scene starts: its first keyframe, or its reference configuration."""

import mujoco


def reset(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Bring a scene to its start."""
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
