"""The paper's numbers, for tables that show ours beside them.

Bi, Conti, Yang, Sigrist, Dürr, Takahashi (Sony AI): *Bridging the sim2real gap in the table tennis
robot with a transformer-based ball states predictor*.
"""

from typing import NamedTuple


class Transfer(NamedTuple):
    """Hits and returns of one set of measured shots at one triple of horizons."""

    physics_hits: int
    physics_returns: int
    learned_hits: int
    learned_returns: int


# Its table "Sim-to-real transfer results": shots of each set, and results by set and horizons (ms).
SHOTS = {"stroke_pro": 200, "stroke_uni": 200, "receive": 100}
TRANSFER = {
    ("stroke_pro", "115-125"): Transfer(136, 81, 170, 117),
    ("stroke_pro", "170-180"): Transfer(114, 75, 164, 92),
    ("stroke_uni", "115-125"): Transfer(154, 80, 195, 146),
    ("stroke_uni", "170-180"): Transfer(137, 86, 187, 125),
    ("receive", "115-125"): Transfer(98, 68, 98, 76),
    ("receive", "170-180"): Transfer(96, 67, 97, 68),
}
