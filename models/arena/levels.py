"""Parameters of players of four levels.

Amateur and club strokes follow the ball states that D'Ambrosio et al. (2025, arXiv 2408.03906)
published: 10,487 launches in rallies and 2,168 serves. Constants marked *public* are fitted to
them (speeds by a regression of the mean speed along the table on place, height and landing place,
spin by component). Semi-professionals and professionals are assumptions from what is known of their
game: balls of 10-20 m/s, loops of 300-600 rad/s, reactions near 0.2 s.
"""

from dataclasses import dataclass, fields

import numpy as np

from rallygap.models.ball.types import Floats, Integers

PERSONAL_SPREAD = 0.08  # standard deviation of log(trait of a player / trait of the level)

LEVELS = ("amateur", "club", "semi_pro", "pro")
TRAITS = {
    "reaction": (0.28, 0.25, 0.22, 0.19),
    "movement": (1.0, 1.3, 1.7, 2.1),
    "reach": (0.45, 0.5, 0.55, 0.6),
    "timing": (1.0, 1.0, 1.0, 0.95),
    "pace": (0.90, 0.94, 1.15, 1.25),
    "attack": (0.12, 0.22, 0.5, 0.7),
    "attack_pace": (1.2, 1.3, 1.6, 1.8),
    "topspin": (38.0, 44.0, 110.0, 150.0),
    "attack_topspin": (80.0, 105.0, 260.0, 420.0),
    "sidespin": (14.0, 15.0, 30.0, 40.0),
    "backspin": (0.25, 0.20, 0.20, 0.15),
    "angle_error": (2.0, 1.8, 0.95, 0.6),
    "speed_error": (0.045, 0.035, 0.025, 0.018),
    "spin_error": (0.15, 0.12, 0.10, 0.08),
    "serve_pace": (0.91, 0.94, 1.05, 1.1),
    "serve_spin": (1.0, 1.15, 4.5, 7.0),
}


@dataclass(frozen=True)
class Players:
    """Traits of B players, each (B,)."""

    reaction: Floats  # s until the player moves after the opponent's stroke
    movement: Floats  # m/s
    reach: Floats  # m around the ready position
    timing: Floats  # preferred moment of contact, as a share of the time from bounce to apex
    pace: Floats  # factor on the speed of strokes
    attack: Floats  # probability to attack a ball that is high and close enough
    attack_pace: Floats  # factor on the speed of an attack
    topspin: Floats  # rad/s of strokes other than attacks
    attack_topspin: Floats  # rad/s of a loop
    sidespin: Floats  # rad/s, scale of side- and corkscrew spin
    backspin: Floats  # probability to push with backspin where the ball is not attacked
    angle_error: Floats  # degrees, of a stroke at rest
    speed_error: Floats  # share, of a stroke at rest
    spin_error: Floats  # share
    serve_pace: Floats  # factor on the speed of serves
    serve_spin: Floats  # factor on the spin of serves

    @classmethod
    def draw(cls, level: str, count: int, random: np.random.Generator) -> "Players":
        """Draw players around a level."""
        spread = np.exp(PERSONAL_SPREAD * random.standard_normal((len(TRAITS), count)))
        column = LEVELS.index(level)
        values = zip(TRAITS.items(), spread, strict=True)
        return cls(**{name: of_levels[column] * factor for (name, of_levels), factor in values})

    def take(self, rows: Integers) -> "Players":
        """Return the traits of some of the players."""
        return Players(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})
