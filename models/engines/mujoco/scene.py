"""A scene of MuJoCo as an engine."""

import copy
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from rallygap.models.ball.state import POSITION, SPIN, STATE_SIZE, VELOCITY
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.engines.engine import EngineError
from rallygap.models.engines.mujoco.ball import Ball, find_ball
from rallygap.models.engines.mujoco.frame import TableFrame, find_frame
from rallygap.models.engines.mujoco.simulation import collected_warnings, reset
from rallygap.models.support.suggestion import suggestion

INTEGRATORS = {
    "Euler": mujoco.mjtIntegrator.mjINT_EULER,
    "RK4": mujoco.mjtIntegrator.mjINT_RK4,
    "implicit": mujoco.mjtIntegrator.mjINT_IMPLICIT,
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
}
ROUNDING = 1e-9  # of a step: times that are so near to one need no further step


@dataclass(frozen=True, eq=False)
class MujocoScene:
    """A scene of MuJoCo that flies its ball.

    Each ball starts alone in the scene, everything else as the scene starts: at its first keyframe
    or, without one, at its reference configuration. Every ball starts in the orientation that the
    ball has there.

    Attributes:
        name: of the scene, for reports.
        model: the scene; never changed.
        ball: its ball.
        frame: its table frame.
    """

    name: str
    model: mujoco.MjModel
    ball: Ball
    frame: TableFrame

    @classmethod
    def of(cls, name: str, model: mujoco.MjModel, ball: str | None = None) -> "MujocoScene":
        """Find ball and table in a scene.

        Args:
            name: of the scene.
            model: the scene.
            ball: name of the ball's body; None to find it.

        Raises:
            EngineError: the scene has no ball, or several.
        """
        known = find_ball(model, ball)
        return cls(name, model, known, find_frame(model, known))

    @property
    def content(self) -> bytes:
        """All that its flights follow from: the compiled model, and which body is the ball."""
        model = np.empty(mujoco.mj_sizeModel(self.model), dtype=np.uint8)
        mujoco.mj_saveModel(self.model, None, model)
        return model.tobytes() + self.ball.name.encode()

    def with_step(self, step: float) -> "MujocoScene":
        """Return this scene with another time step (s).

        Raises:
            EngineError: the step is not positive.
        """
        if not step > 0.0:
            raise EngineError(f"a time step of {step:g} s; give one above 0")
        model = copy.copy(self.model)
        model.opt.timestep = step
        return replace(self, model=model)

    def with_integrator(self, name: str) -> "MujocoScene":
        """Return this scene with another integrator: Euler, RK4, implicit or implicitfast.

        Raises:
            EngineError: there is no such integrator.
        """
        if name not in INTEGRATORS:
            hint = suggestion(name, INTEGRATORS)
            raise EngineError(f"there is no integrator called {name!r}; {hint}")
        model = copy.copy(self.model)
        model.opt.integrator = INTEGRATORS[name]
        return replace(self, model=model)

    def fly(self, states: Floats, times: Floats) -> Floats:
        """Fly balls, as ``Engine`` does.

        Raises:
            EngineError: the simulation diverges; names the ball and the time.
        """
        model = copy.copy(self.model)
        # It does not start again when it diverges: that would look like a flight.
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
        data = mujoco.MjData(model)
        launches = self.frame.to_world(np.asarray(states, dtype=np.float64))
        flown = np.empty((len(launches), len(times), STATE_SIZE))
        for number, launch in enumerate(launches):
            try:
                flown[number] = self._flight(model, data, launch, np.asarray(times))
            except EngineError as error:
                raise EngineError(f"{self.name}: ball {number}: {error}") from None
        return self.frame.to_table(flown)

    def _flight(
        self, model: mujoco.MjModel, data: mujoco.MjData, launch: Floats, times: Floats
    ) -> Floats:
        """Return (T, 9) states of the world's frame, of one ball."""
        step = model.opt.timestep
        count = max(1, int(np.ceil(times.max(initial=0.0) / step - ROUNDING)))
        reset(model, data)
        first, moving = self.ball.position, self.ball.velocity
        pose, motion = data.qpos[first : first + 7], data.qvel[moving : moving + 6]
        pose[:3], motion[:3] = launch[POSITION], launch[VELOCITY]
        motion[3:] = launch[SPIN] @ rotations(pose[3:])
        path = np.empty((count + 1, 13))  # position, quaternion, velocity, spin of the body
        contacts = np.zeros(count + 1, dtype=np.bool_)
        path[0] = (*pose, *motion)
        with collected_warnings() as warnings:
            for number in range(1, count + 1):
                mujoco.mj_step(model, data)
                path[number, :7], path[number, 7:] = pose, motion
                contacts[number] = data.ncon > 0 and self.ball.geom in data.contact.geom
        if data.warning.number.any():
            raise EngineError(next(text for text in warnings if "Time = " in text))
        spins = np.einsum("kij,kj->ki", rotations(path[:, 3:7]), path[:, 10:])
        states = np.column_stack([path[:, :3], path[:, 7:10], spins])
        # Euler finds contacts at the start of a step, RK4 leaves those at its end.
        return _states_between(states, contacts[1:] | contacts[:-1], step, times)


def rotations(quaternions: Floats) -> Floats:
    """Return (..., 3, 3) rotation matrices, body to world, of (..., 4) unit quaternions."""
    w, x, y, z = np.moveaxis(quaternions, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def _states_between(states: Floats, touches: Bools, step: float, times: Floats) -> Floats:
    """Return states at any times from those at the steps.

    The time step of a scene belongs to it, above all to its contacts, so a flight is not stepped
    to the times that are asked for. Velocity and spin are linear within a step. The position
    follows the cubic with the velocities at both ends; within a step that touches something the
    velocity jumps, and the position is linear. With RK4 at 2 ms that adds errors of 1e-11 m and
    3e-5 m/s to those of the steps; with Euler, whose steps err by 9e-3 m, 2e-5 m.

    Args:
        states: (K + 1, 9) at the steps, K of at least one.
        touches: (K,) whether the ball touches anything in the step from one state to the next.
        step: s.
        times: (T,) s, from 0 to K steps.

    Returns:
        (T, 9) states.
    """
    first = np.clip((times / step).astype(np.int64), 0, len(states) - 2)
    share = (times / step - first)[:, None]
    before, after = states[first], states[first + 1]
    between = np.empty((len(times), STATE_SIZE))
    between[:] = (1.0 - share) * before + share * after
    straight = after[:, POSITION] - before[:, POSITION]
    start = step * before[:, VELOCITY] - straight
    end = step * after[:, VELOCITY] - straight
    bend = share * (1.0 - share) * ((1.0 - share) * start - share * end)  # of the cubic, m
    between[:, POSITION] += np.where(touches[first][:, None], 0.0, bend)
    return between
