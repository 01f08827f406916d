"""Strokes: the player's plan, its aim over the net, and its execution with errors.

All states are in the frame of the player who strikes, at y < 0 and playing towards +y, but those of
the aim, which the physics (wind, tilt) wants in the table frame.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from rallygap.models.arena.levels import Players
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import (
    BALL_RADIUS,
    NET_HEIGHT,
    SPIN,
    STATE_SIZE,
    TABLE_HALF_LENGTH,
    TABLE_HALF_WIDTH,
    VELOCITY,
)
from rallygap.models.ball.types import Bools, Floats

# Mean speed along the table (m/s) of public rally launches: regression of its logarithm on y and z
# of the launch and y of the landing, with a residual standard deviation of 0.17.
SPEED_AT = (-1.22, 0.42, 0.81)  # m, medians
MEAN_SPEED = 4.35
SPEED_SLOPES = (-0.25, -0.44, 0.30)  # 1/m
SPEED_SPREAD = 0.13  # below 0.17: errors, attacks and pushes add the rest
FASTEST = 20.0  # m/s along the table, assumption

# Where public rally launches land: y, and x with its slope on x of the launch.
LANDING_LENGTH = 0.80  # m
LANDING_SPREAD = 0.27  # m
LANDING_SIDE = 0.28  # m, spread
LANDING_SLOPE = 0.13
LANDING_MARGIN = 0.12  # m from the lines
ATTACK_LENGTH, ATTACK_SIDE = 0.95, 0.42  # m; assumption: attacks are placed away from the player

PUBLIC_TOPSPIN = 41.0  # rad/s, median
TOPSPIN_SPREAD = 27.0  # rad/s, public
TOPSPIN_OF_SPEED = 12.0  # rad/s per standard deviation of speed, public
SIDE_TAIL = 3.0  # degrees of freedom of Student's t: public side spins have long tails

# Assumptions about the kinds of strokes. Attacks are loops, above the net's height also smashes.
ATTACK_HEIGHT = (0.22, 0.05)  # m: below it attacks are rare; the width of the change
SMASH_HEIGHT = (0.50, 0.06)
SMASH_PACE, SMASH_SPIN = 1.25, 0.3  # of a loop's, of a stroke's
PUSH_PACE, PUSH_SPIN = 0.85, -0.6  # of a stroke's

# Assumptions about errors: values at which a term adds as much as the error at rest.
ERROR_OF_STRETCH = 2.0  # times that, at full stretch
ERROR_OF_SPEED = 10.0  # m/s of the incoming ball
ERROR_OF_SPIN = 400.0  # rad/s of the incoming ball
ERROR_OF_STROKE_SPEED = 14.0  # m/s of the stroke

CORRECTIONS = 5  # iterations; millimetres remain, less than the players' errors
PATH_SAMPLES = 16  # points of a flight at which its height over the net is taken
LENGTHENING = 1.12  # factor on the time of a flight that would not clear the net
MAX_LENGTHENINGS = 8


def plan_strokes(
    balls: Floats, stretch: Floats, players: Players, random: np.random.Generator
) -> tuple[Floats, Floats, Floats]:
    """Choose strokes at random, by height of the ball and stretch.

    Args:
        balls: (B, 9) incoming states at the contact.
        stretch: (B,) needed share of the player's range, from 0 to 1.
        players: (B,) striking players.
        random: of all random choices.

    Returns:
        Planned landing points (B, 2) m, spins (B, 3) rad/s and flight times (B,) s.
    """
    attacks, smashes, pushes = _kinds(balls[:, 2], stretch, players, random)
    targets = _targets(balls[:, 0], attacks, random)
    noise = random.standard_normal(len(balls))
    place = np.column_stack([balls[:, 1:3], targets[:, 1]]) - SPEED_AT
    pace = players.pace * _factor(attacks, players.attack_pace) * _factor(smashes, SMASH_PACE)
    pace = pace * _factor(pushes, PUSH_PACE)
    speed = MEAN_SPEED * pace * np.exp(place @ SPEED_SLOPES + SPEED_SPREAD * noise)
    speed = np.minimum(speed, FASTEST)
    topspin = np.where(attacks & ~smashes, players.attack_topspin, players.topspin)
    topspin = topspin * _factor(pushes, PUSH_SPIN) * _factor(smashes, SMASH_SPIN)
    topspin = topspin + TOPSPIN_OF_SPEED * noise
    spread = TOPSPIN_SPREAD * np.sqrt(np.maximum(players.topspin / PUBLIC_TOPSPIN, 1.0))
    side = players.sidespin * random.standard_t(SIDE_TAIL, (2, len(balls))).clip(-6, 6)
    topspin = topspin + spread * random.standard_normal(len(balls))
    spins = spin_vectors(targets - balls[:, :2], topspin, *side)
    return targets, spins, (targets[:, 1] - balls[:, 1]) / speed


def aim_launches(
    simulator: Simulator,
    positions: Floats,
    spins: Floats,
    targets: Floats,
    times: Floats,
    clearances: Floats,
) -> Floats:
    """Return (B, 9) launches that reach their targets; longer flights where the net is in the way.

    Args:
        simulator: physics that the players know.
        positions: (B, 3) racket contacts, m.
        spins: (B, 3) after the stroke, rad/s.
        targets: (B, 2) on the table, m.
        times: (B,) durations of the flights, s.
        clearances: (B,) smallest distances between ball and net, m. Where no flight keeps them,
            the last one tried is returned.
    """
    air, times = simulator.without_surfaces(), times.copy()
    launches = _reaching(air, positions, spins, targets, times)
    for _ in range(MAX_LENGTHENINGS):
        low = np.flatnonzero(_above_net(air, launches, times) < clearances)
        if not len(low):
            break
        times[low] *= LENGTHENING
        launches[low] = _reaching(air, positions[low], spins[low], targets[low], times[low])
    return launches


def _reaching(
    air: Simulator, positions: Floats, spins: Floats, targets: Floats, times: Floats
) -> Floats:
    """Return launches that reach their targets at given times (fixed-point iteration)."""
    ends = np.column_stack([targets, np.full(len(targets), BALL_RADIUS)])
    span = times[:, None]
    launches = np.empty((len(positions), STATE_SIZE))
    launches[:, :3], launches[:, 6:] = positions, spins
    launches[:, 3:6] = (ends - positions) / span + [0.0, 0.0, 4.9] * span
    for _ in range(CORRECTIONS):
        reached = air.fly(launches, span).states[:, 0, :3]
        launches[:, 3:6] += (ends - reached) / span
    return launches


def _above_net(air: Simulator, launches: Floats, times: Floats) -> Floats:
    """Return how far above the net balls pass (m)."""
    paths = air.fly(launches, times[:, None] * np.linspace(0, 1, PATH_SAMPLES)).states
    y, z = paths[..., 1] * np.sign(launches[:, 4:5]), paths[..., 2]
    ahead = np.clip((y >= 0).argmax(axis=1), 1, None)
    rows = np.arange(len(paths))
    y0, y1, z0, z1 = y[rows, ahead - 1], y[rows, ahead], z[rows, ahead - 1], z[rows, ahead]
    at_net = z0 - y0 * (z1 - z0) / np.where(y1 == y0, 1.0, y1 - y0)
    return at_net - NET_HEIGHT - BALL_RADIUS


def execute_strokes(
    launches: Floats, balls: Floats, stretch: Floats, players: Players, random: np.random.Generator
) -> Floats:
    """Return (B, 9) launches with execution errors.

    Errors depend on the player and grow with the speed and spin of the incoming ball, with the
    stretch and with the speed of the stroke.
    """
    speeds = np.linalg.norm(launches[:, VELOCITY], axis=1)
    difficulty = (
        1.0
        + ERROR_OF_STRETCH * stretch**3
        + np.linalg.norm(balls[:, VELOCITY], axis=1) / ERROR_OF_SPEED
        + np.linalg.norm(balls[:, SPIN], axis=1) / ERROR_OF_SPIN
        + (speeds / ERROR_OF_STROKE_SPEED) ** 2
    )
    return add_execution_errors(launches, difficulty, players, random)


def add_execution_errors(
    launches: Floats, difficulty: Floats, players: Players, random: np.random.Generator
) -> Floats:
    """Return launches with errors of direction, speed and spin, scaled by (B,) ``difficulty``."""
    count = len(launches)
    struck = launches.copy()
    turns = np.radians(players.angle_error) * difficulty * random.standard_normal((3, count))
    turn = Rotation.from_rotvec(turns.T)
    faster = 1 + players.speed_error * difficulty * random.standard_normal(count)
    spun = 1 + players.spin_error * random.standard_normal(count)
    struck[:, VELOCITY] = turn.apply(struck[:, VELOCITY]) * np.clip(faster, 0.5, 1.5)[:, None]
    struck[:, SPIN] = turn.apply(struck[:, SPIN]) * np.clip(spun, 0.0, 2.0)[:, None]
    return struck


def spin_vectors(
    directions: Floats, topspin: Floats, corkscrew: Floats, sidespin: Floats
) -> Floats:
    """Return (B, 3) spins: topspin across (B, 2) directions of flight, corkscrew along them."""
    ahead = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    x = -topspin * ahead[:, 1] + corkscrew * ahead[:, 0]
    y = topspin * ahead[:, 0] + corkscrew * ahead[:, 1]
    return np.column_stack([x, y, sidespin])


def _kinds(
    heights: Floats, stretch: Floats, players: Players, random: np.random.Generator
) -> tuple[Bools, Bools, Bools]:
    """Return which balls are attacked, which of these are smashed, and which are pushed."""
    uniform, other = random.random((2, len(heights)))
    ease = np.clip(1.4 * (1 - stretch), 0, 1)
    attacks = uniform < players.attack * ease * _above(heights, *ATTACK_HEIGHT)
    smashes = attacks & (other < _above(heights, *SMASH_HEIGHT))
    pushes = ~attacks & (other < players.backspin)
    return attacks, smashes, pushes


def _targets(across: Floats, attacks: Bools, random: np.random.Generator) -> Floats:
    """Return (B, 2) landing places; attacks land long."""
    noise = random.standard_normal((2, len(across)))
    x = LANDING_SLOPE * across + np.where(attacks, ATTACK_SIDE, LANDING_SIDE) * noise[0]
    y = np.where(attacks, ATTACK_LENGTH, LANDING_LENGTH) + LANDING_SPREAD * noise[1]
    side, end = TABLE_HALF_WIDTH - LANDING_MARGIN, TABLE_HALF_LENGTH - LANDING_MARGIN
    return np.column_stack([np.clip(x, -side, side), np.clip(y, 0.25, end)])


def _above(heights: Floats, middle: float, width: float) -> Floats:
    return 1 / (1 + np.exp(-(heights - middle) / width))


def _factor(applies: Bools, factor: float | Floats) -> Floats:
    return np.where(applies, factor, 1.0)
