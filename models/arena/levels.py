"""Parameters of players of four levels.

Amateur and club strokes follow the ball states that D'Ambrosio et al. (2025, arXiv 2408.03906)
published: 10,487 launches in rallies and 2,168 serves. Constants marked *public* are fitted to
them (speeds by a regression of the mean speed along the table on place, height and landing place,
spin by component). Semi-professionals and professionals are assumptions from what is known of their
game: balls of 10-20 m/s, loops of 300-600 rad/s, reactions near 0.2 s.
"""

from dataclasses import dataclass, fields
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Number = TypeVar("Number", float, NDArray[np.float64])

PERSONAL_SPREAD = 0.08  # standard deviation of log(trait of a player / trait of the level)


@dataclass(frozen=True)
class Traits(Generic[Number]):
    """Skills of a player: numbers for a level, or (B,) arrays for individual players.

    Attributes:
        reaction: s until the player moves after the opponent's stroke.
        movement: m/s.
        reach: m around the ready position.
        timing: preferred moment of contact, as a share of the time from bounce to apex.
        pace: factor on the speed of strokes.
        attack: probability to attack a ball that is high and close enough.
        attack_pace: factor on the speed of an attack.
        topspin: rad/s of strokes other than attacks.
        attack_topspin: rad/s of a loop.
        sidespin: rad/s, scale of side- and corkscrew spin.
        backspin: probability to push with backspin where the ball is not attacked.
        angle_error: degrees, of a stroke at rest.
        speed_error: share, of a stroke at rest.
        spin_error: share.
        serve_pace: factor on the speed of serves.
        serve_spin: factor on the spin of serves.
    """

    reaction: Number
    movement: Number
    reach: Number
    timing: Number
    pace: Number
    attack: Number
    attack_pace: Number
    topspin: Number
    attack_topspin: Number
    sidespin: Number
    backspin: Number
    angle_error: Number
    speed_error: Number
    spin_error: Number
    serve_pace: Number
    serve_spin: Number

    def individuals(
        self: "Traits[float]", count: int, random: np.random.Generator
    ) -> "Traits[Floats]":
        """Draw players around this level."""
        spread = np.exp(PERSONAL_SPREAD * random.standard_normal((len(fields(self)), count)))
        names = [field.name for field in fields(self)]
        traits = {name: getattr(self, name) * s for name, s in zip(names, spread, strict=True)}
        return Traits(**traits)

    def take(self: "Traits[Floats]", rows: NDArray[np.int64]) -> "Traits[Floats]":
        """Return the traits of some of the players."""
        return Traits(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})


Players = Traits[Floats]

LEVELS: dict[str, Traits[float]] = {
    "amateur": Traits(
        reaction=0.28,
        movement=1.0,
        reach=0.45,
        timing=1.0,
        pace=0.90,
        attack=0.12,
        attack_pace=1.2,
        topspin=38.0,
        attack_topspin=80.0,
        sidespin=14.0,
        backspin=0.25,
        angle_error=2.0,
        speed_error=0.045,
        spin_error=0.15,
        serve_pace=0.91,
        serve_spin=1.0,
    ),
    "club": Traits(
        reaction=0.25,
        movement=1.3,
        reach=0.5,
        timing=1.0,
        pace=0.94,
        attack=0.22,
        attack_pace=1.3,
        topspin=44.0,
        attack_topspin=105.0,
        sidespin=15.0,
        backspin=0.20,
        angle_error=1.8,
        speed_error=0.035,
        spin_error=0.12,
        serve_pace=0.94,
        serve_spin=1.15,
    ),
    "semi_pro": Traits(
        reaction=0.22,
        movement=1.7,
        reach=0.55,
        timing=1.0,
        pace=1.15,
        attack=0.5,
        attack_pace=1.6,
        topspin=110.0,
        attack_topspin=260.0,
        sidespin=30.0,
        backspin=0.20,
        angle_error=0.95,
        speed_error=0.025,
        spin_error=0.10,
        serve_pace=1.05,
        serve_spin=4.5,
    ),
    "pro": Traits(
        reaction=0.19,
        movement=2.1,
        reach=0.6,
        timing=0.95,
        pace=1.25,
        attack=0.7,
        attack_pace=1.8,
        topspin=150.0,
        attack_topspin=420.0,
        sidespin=40.0,
        backspin=0.15,
        angle_error=0.6,
        speed_error=0.018,
        spin_error=0.08,
        serve_pace=1.1,
        serve_spin=7.0,
    ),
}
