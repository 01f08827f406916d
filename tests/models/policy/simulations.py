"""Balls and simulations for the tests."""

import numpy as np

from rallygap.models.ball.simulators import shipped
from rallygap.models.policy.batch_simulation import BatchSimulation
from rallygap.models.policy.goals import Goals
from rallygap.models.policy.incoming_balls import PATH_TIMES, IncomingBalls, control_times
from rallygap.models.robot.constants import NEUTRAL
from rallygap.models.robot.kinematics import racket

SIMULATOR = shipped("ground_truth")
WAITING = racket(NEUTRAL[None], np.zeros((1, 6)))
CENTRE, NORMAL = WAITING.position[0], WAITING.normal[0]

ARRIVAL = 0.200  # s from the launch until the ball would be at its place
STILL = np.zeros((1, 5))


def beside_centre(across=0.0, above=0.0):
    """Return a place next to the centre of the waiting racket."""
    return np.array([CENTRE[0] + across, CENTRE[1], CENTRE[2] + above])


def passing(
    *places, velocity=(0.0, -5.0, 0.0), spin=(0.0, 0.0, 0.0), playable=(0.0, 0.4), arrival=ARRIVAL
):
    """Return balls in free flight that would be at ``places`` after ``arrival`` seconds."""
    there = [np.concatenate([place, velocity, spin]) for place in places]
    path = SIMULATOR.fly(np.array(there), PATH_TIMES - arrival).states
    ticks = len(control_times(0.0))
    forecasts = np.broadcast_to(path[:, :1, None], (len(path), ticks, 3, 9))
    return IncomingBalls(path, np.tile(playable, (len(path), 1)), 0.0, forecasts)


def goals(count=1):
    return Goals(np.tile([0.1, 0.8], (count, 1)))


def simulation_with(incoming, simulator=SIMULATOR, latency=0.0):
    simulation = BatchSimulation(simulator, len(incoming), "strict", latency)
    simulation.reset(np.ones(len(incoming), dtype=bool), incoming, goals(len(incoming)))
    return simulation


def played(simulation, actions=STILL):
    """Play until an episode ends; return its step and the rewards of all steps."""
    rewards = []
    while True:
        step = simulation.step(actions)
        rewards.append(step.reward)
        if step.done.any():
            return step, np.array(rewards)
