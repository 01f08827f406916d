"""A policy learns to meet the ball, with the ball of a scene and with the amended ball.

    python docs/examples/mujoco_interception.py verdict/ball_effects.py

A paddle moves in a plane behind the table, too slowly to follow the ball: the policy must know
where it will pass. One policy is trained with the scene as it is, in which there is no air, and one
with the amended ball. Both then meet the same new shots of it. It takes about two minutes.
"""

import argparse
import runpy
from pathlib import Path
from typing import Any

import gymnasium
import mujoco
import numpy as np
from gymnasium.spaces import Box
from gymnasium_ball import AmendedBall
from numpy.typing import NDArray
from stable_baselines3 import SAC

Floats = NDArray[np.float64]
Observation = NDArray[np.float32]

SCENE = Path(__file__).with_suffix(".xml")
# Position (m), velocity (m/s) and spin (rad/s) of a shot: the middle of a range, and half of it.
SHOT = np.array([0.0, 1.3, 0.3, 0.0, -5.3, 1.2, -75.0, 0.0, 0.0])
SPREAD = np.array([0.2, 0.02, 0.02, 0.3, 0.3, 0.2, 30.0, 0.0, 0.0])
PLANE, FLOOR = -1.5, -0.76  # m: y of the paddle, z of the floor
RADIUS = 0.08  # m, of the paddle
FRAMES = 5  # time steps of the scene between two looks at the ball
LOOKS = 8  # per action
SIZES = np.array([1, 1, 1, 5, 5, 5, 150, 150, 150, 1, 1, 1, 1])  # of what is observed
FAR = 0.2  # m, a distance that costs a reward of 1
STEPS = 4000  # of training
TESTED = 100  # shots


class Interception(gymnasium.Env):
    """A ball comes over the table; the paddle is to be where it passes the paddle's plane.

    Observed are position, velocity and spin of the ball, place and velocity of the paddle, each
    over a typical size. The action is the place (m) to which the paddle's motors move it. At the
    end, ``info["error"]`` is the distance (m) from the paddle's centre to the ball, and the reward
    is minus that; before, it is 0.
    """

    def __init__(self) -> None:
        self.model = mujoco.MjModel.from_xml_path(str(SCENE))
        self.data = mujoco.MjData(self.model)
        self.observation_space = Box(-np.inf, np.inf, (self.model.nsensordata,), np.float32)
        low, high = self.model.actuator_ctrlrange.T.astype(np.float32)
        self.action_space = Box(low, high, dtype=np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Shoot a ball."""
        super().reset(seed=seed)
        mujoco.mj_resetData(self.model, self.data)
        shot = SHOT + SPREAD * self.np_random.uniform(-1.0, 1.0, len(SHOT))
        self.data.qpos[:3], self.data.qvel[:6] = shot[:3], shot[3:]
        mujoco.mj_forward(self.model, self.data)
        return self._observed(), {}

    def step(self, action: Floats) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Move towards a place for 80 ms, or until the ball passes."""
        for _ in range(LOOKS):
            before = self._offset()
            self.do_simulation(action, FRAMES)
            after = self._offset()
            if after[1] < 0.0 or self.data.qpos[2] < FLOOR:
                error = _distance(before, after)
                return self._observed(), -error / FAR, True, False, {"error": error}
        return self._observed(), 0.0, False, False, {}

    def do_simulation(self, ctrl: Floats, n_frames: int) -> None:
        """Simulate time steps of the scene; ``AmendedBall`` replaces this."""
        self.data.ctrl[:] = ctrl
        mujoco.mj_step(self.model, self.data, nstep=n_frames)

    def _observed(self) -> Observation:
        return (self.data.sensordata / SIZES).astype(np.float32)

    def _offset(self) -> Floats:
        """Return the (3,) place of the ball, seen from the paddle."""
        across, up = self.data.qpos[-2:]
        return self.data.qpos[:3] - (across, PLANE, up)


def _distance(before: Floats, after: Floats) -> float:
    """Return the distance in the paddle's plane, where a straight path passes it."""
    # A ball that falls short does not pass it; np.interp then takes its last place.
    sides = [np.interp(0.0, [-before[1], -after[1]], [before[k], after[k]]) for k in (0, 2)]
    return float(np.hypot(*sides))


def trained(env: gymnasium.Env, steps: int) -> SAC:
    """Return a policy after so many steps in an environment."""
    policy = SAC(
        "MlpPolicy",
        env,
        learning_rate=lambda remaining: 1e-3 * remaining,
        batch_size=128,
        gamma=0.98,
        ent_coef=0.01,
        gradient_steps=2,
        policy_kwargs={"net_arch": [64, 64]},
        seed=0,
        device="cpu",
    )
    return policy.learn(steps)


def errors(policy: SAC, env: gymnasium.Env) -> Floats:
    """Return the distances (m) at which the ball passes, of the same shots for all policies."""
    return np.array([_error(policy, env, 1000 + number) for number in range(TESTED)])


def _error(policy: SAC, env: gymnasium.Env, seed: int) -> float:
    observed, info = env.reset(seed=seed)
    while "error" not in info:
        action, _ = policy.predict(observed, deterministic=True)
        observed, _, _, _, info = env.step(action)
    return info["error"]


def main(code: str, steps: int = STEPS) -> None:
    """Train both policies and print how they meet the balls; ``code`` is a ball_effects.py."""
    ball = runpy.run_path(code)["Ball"]
    scene, amended = Interception(), AmendedBall(Interception(), ball)
    print("trained with   plays         hits   median error")
    _report("scene", trained(scene, steps), {"scene": scene, "amended ball": amended})
    _report("amended ball", trained(amended, steps), {"amended ball": amended})


def _report(name: str, policy: SAC, played: dict[str, gymnasium.Env]) -> None:
    for ball, env in played.items():
        found = errors(policy, env)
        hits, median = (found < RADIUS).mean(), 1e3 * np.median(found)
        print(f"{name:13}  {ball:12}  {hits:4.0%}   {median:4.0f} mm", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("code", help="ball_effects.py, of rallygap export --to mujoco")
    main(parser.parse_args().code)
