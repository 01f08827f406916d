"""Serves: the toss, and a stroke that bounces on both sides.

States are in the frame of the server, at y < 0 and playing towards +y. They are turned into the
table frame for simulation, because the physics (wind, tilt) depends on the direction.
"""

import numpy as np

from rallygap.models.arena.levels import Players
from rallygap.models.arena.sides import switch_frame
from rallygap.models.arena.strokes import SIDE_TAIL, add_execution_errors, spin_vectors
from rallygap.models.ball.contact_laws import TABLE
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rallygap.models.ball.types import Floats

# Where serves are struck: public but for y, which the rules want behind the end line.
STRIKE_SIDE = (0.34, 0.17)  # m from the middle, mean and spread
FOREHAND_SIDE = 0.6  # share of the serves from x > 0
STRIKE_LENGTH = (-1.45, 0.04)  # m
STRIKE_HEIGHT = (0.26, 0.085)  # m

# The toss: upwards from an open palm, at least 16 cm, struck as it falls (ITTF Law 2.6).
TOSS_HEIGHT = 0.19  # m at least
TOSS_EXTRA = (0.12, 0.7)  # m, median, and spread of its logarithm; assumption
LOWEST_PALM = 0.06  # m above the table's level
TOSS_DRIFT = 0.05  # m/s
TOSS_TIMES = np.arange(0.0, 1.6, 0.005)  # s

# Launches of public serves.
SPEED = 5.45  # m/s
SPEED_OF_HEIGHT = -1.1  # 1/m, slope of its logarithm
SPEED_SPREAD = 0.13
ELEVATION = (-20.0, 5.5)  # degrees
LANDING_SIDE = 0.25  # m, spread
LANDING_LENGTH = 0.5  # m
TOPSPIN = (3.0, 17.0)  # rad/s, mean and spread
CORKSCREW, SIDESPIN = 10.0, 12.0  # rad/s, scales of Student's t

CANDIDATES = 16  # drawn per serve; the first valid one is played
MARGIN = 0.08  # m inside the lines
DIFFICULTY = 1.0  # of a serve; see ``add_execution_errors``


def toss(
    air: Simulator, directions: Floats, random: np.random.Generator
) -> tuple[Floats, Floats, Floats]:
    """Toss balls.

    Args:
        air: simulator without table and net.
        directions: (B,) 1 for servers at y < 0, -1 for the others.
        random: of all random choices.

    Returns:
        (B, 9) states at the palm, (B,) s until the strike and (B, 9) states just before it.
    """
    count = len(directions)
    side, length, height, more = random.standard_normal((4, count))
    forehand = np.where(random.random(count) < FOREHAND_SIDE, 1, -1)
    palms = np.zeros((count, 9))
    palms[:, 0] = forehand * (STRIKE_SIDE[0] + STRIKE_SIDE[1] * side)
    palms[:, 1] = np.minimum(STRIKE_LENGTH[0] + STRIKE_LENGTH[1] * length, -1.39)
    strike_height = np.clip(STRIKE_HEIGHT[0] + STRIKE_HEIGHT[1] * height, 0.12, 0.6)
    palms[:, 2] = np.maximum(strike_height - random.uniform(0, 0.1, count), LOWEST_PALM)
    rise = TOSS_HEIGHT + TOSS_EXTRA[0] * np.exp(np.clip(TOSS_EXTRA[1] * more, -2, 2))
    palms[:, 5] = np.sqrt(2 * 9.81 * rise)
    palms[:, 3:5] = TOSS_DRIFT * random.standard_normal((count, 2))
    palms[:, 4] = -np.abs(palms[:, 4])  # away from the table: the rules want the strike there
    paths = switch_frame(air.fly(switch_frame(palms, directions), TOSS_TIMES).states, directions)
    falling = (paths[..., 5] < 0) & (paths[..., 2] <= strike_height[:, None])
    strike = falling.argmax(axis=1)
    return palms, TOSS_TIMES[strike], paths[np.arange(count), strike]


def plan_serves(
    simulator: Simulator,
    balls: Floats,
    directions: Floats,
    players: Players,
    random: np.random.Generator,
) -> Floats:
    """Return (B, 9) launches of serves of falling balls (B, 9)."""
    count = len(balls)
    candidates = _candidates(balls, players, random)
    flat = switch_frame(candidates.reshape(-1, 9), np.repeat(directions, CANDIDATES))
    # A serve bounces once on each side, without touching the net.
    contacts = simulator.fly(flat, np.array([0.0, 0.9])).contacts
    x = contacts.before[:, :2, 0]
    y = contacts.before[:, :2, 1] * np.repeat(directions, CANDIDATES)[:, None]
    clean = (contacts.surface[:, :2] == TABLE).all(axis=1)
    inside = (np.abs(x) < TABLE_HALF_WIDTH - MARGIN).all(axis=1)
    inside &= (y[:, 0] < -MARGIN) & (y[:, 0] > -TABLE_HALF_LENGTH + MARGIN)
    good = clean & inside & (y[:, 1] > MARGIN) & (y[:, 1] < TABLE_HALF_LENGTH - MARGIN)
    chosen = candidates[np.arange(count), good.reshape(count, CANDIDATES).argmax(axis=1)]
    return add_execution_errors(chosen, np.full(count, DIFFICULTY), players, random)


def _candidates(balls: Floats, players: Players, random: np.random.Generator) -> Floats:
    """Return (B, CANDIDATES, 9) launches."""
    shape = (len(balls), CANDIDATES)
    pace, elevation, side, topspin = random.standard_normal((4, *shape))
    corkscrew, sidespin = random.standard_t(SIDE_TAIL, (2, *shape)).clip(-6, 6)
    height = balls[:, 2:3] - STRIKE_HEIGHT[0]
    speed = SPEED * players.serve_pace[:, None]
    speed = speed * np.exp(SPEED_OF_HEIGHT * height + SPEED_SPREAD * pace)
    directions = np.stack(
        [
            LANDING_SIDE * side - balls[:, 0:1],
            np.broadcast_to(LANDING_LENGTH - balls[:, 1:2], shape),
        ],
        axis=-1,
    )
    ahead = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    angle = np.radians(ELEVATION[0] + ELEVATION[1] * elevation)
    candidates = np.empty((*shape, 9))
    candidates[..., :3] = balls[:, None, :3]
    candidates[..., 3:5] = (speed * np.cos(angle))[..., None] * ahead
    candidates[..., 5] = speed * np.sin(angle)
    gain = players.serve_spin[:, None]
    spins = [TOPSPIN[0] + TOPSPIN[1] * topspin, CORKSCREW * corkscrew, SIDESPIN * sidespin]
    flat = [(gain * spin).ravel() for spin in spins]
    candidates[..., 6:] = spin_vectors(directions.reshape(-1, 2), *flat).reshape(*shape, 3)
    return candidates
