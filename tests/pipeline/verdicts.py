"""Made-up verdicts of every kind."""

import numpy as np

from models.ball.simulators import shipped
from models.gap.shots import Shots
from models.gap.verdict import Cause, Gap, Unexplained, Verdict, Where
from pipeline.findings import Findings
from pipeline.shots import MeasuredShots

TIMES = 0.01 * np.arange(20)
PATH = np.column_stack([0 * TIMES, 1.3 - 5 * TIMES, 0.3 + 0 * TIMES])

GAP = Gap(
    horizons_ms=(100, 200, 300),
    before_mm=(9.0, 21.0, 40.0),
    after_mm=(5.0, 8.0, 12.0),
    floor_mm=(4.5, 7.0, 11.0),
    removable_closed=0.9,
    interval=(0.8, 1.0),
)
WIND = Cause(
    name="wind",
    component="x",
    kind="missing_effect",
    parameter="x",
    unit="m/s",
    nominal=0.0,
    estimate=0.61,
    interval=(0.59, 0.63),
    p_value=5e-5,
    gap_share=0.7,
    possible=("wind",),
)
GRAVITY = Cause(
    name="gravity",
    component=None,
    kind="wrong_value",
    parameter="g",
    unit="m/s^2",
    nominal=9.81,
    estimate=10.3,
    interval=(10.2, 10.4),
    p_value=2e-4,
    gap_share=0.3,
    possible=("gravity", "buoyancy"),
)


def verdict(answer="named", causes=(WIND,), **changes):
    """A verdict with some causes; without any nothing arises anywhere."""
    parts = {
        "unexplained": Unexplained(share=0.0, p_value=0.4),
        "where": Where(flight=1.0 if causes else 0.0, table=0.0, sensor=0.0),
        "gap": GAP,
        "detectable": {"wind.x": 0.04, "gravity": 0.06, "friction": 0.012},
        "blind_to": ("buoyancy", "kp"),
        "limits": ("all shots go one way: shoot both ways",),
    }
    return Verdict(verdict=answer, effects=tuple(causes), **{**parts, **changes})


def findings(of=None, called="sim.yaml", name="hall"):
    """Findings with a verdict, on shots without spin labels that fly one way."""
    shots = Shots.from_arrays([TIMES] * 4, [PATH] * 4)
    measured = MeasuredShots(
        name, shots, recordings=5, refused={"not a number": 2}, episodes=6, bounces=0, noise=0.003
    )
    return Findings(measured, shipped("literature"), called, 0.003, of or verdict())
