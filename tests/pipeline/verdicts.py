"""Made-up verdicts of every kind."""

import numpy as np

from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.location import Growth, Located
from rallygap.models.gap.net.contacts import NetContacts
from rallygap.models.gap.settings import DEFAULTS
from rallygap.models.gap.verdict import (
    CameraNodes,
    Cause,
    Check,
    Gap,
    Landing,
    PhaseShares,
    Unexplained,
    Verdict,
    Worth,
)
from rallygap.models.predictors.ball_filter import ANY_BALL
from rallygap.pipeline.gap.measured_shots import LabelCounts, MeasuredShots
from rallygap.pipeline.gap.summary import Findings
from rallygap.pipeline.report.close_gap import CaseVerdict

TIMES = 0.01 * np.arange(20)
PATH = np.column_stack([0 * TIMES, 1.3 - 5 * TIMES, 0.3 + 0 * TIMES])

GAP = Gap(
    horizons_ms=(100, 200, 300),
    before_mm=(9.0, 21.0, 40.0),
    after_mm=(5.0, 8.0, 12.0),
    floor_mm=(4.5, 7.0, 11.0),
    removable_closed=0.9,
    removable_closed_interval=(0.8, 1.0),
    landing=Landing(
        shots=30,
        before_mm=31.0,
        after_mm=14.0,
        floor_mm=12.0,
        before_ms=4.0,
        after_ms=1.9,
        floor_ms=1.5,
        reduction_mm=(11.0, 24.0),
        reduction_ms=(1.2, 3.1),
    ),
    before_interval_mm=((8.0, 10.0), (19.0, 23.5), (36.0, 45.0)),
    after_interval_mm=((4.5, 5.5), (7.0, 9.0), (10.5, 14.0)),
    reduction_mm=(12.0, 18.0),
)
MEANS = 0.001 * np.outer(range(3), [1, 2, 3])  # 1 mm along, 2 across and 3 up a bin
MARGINS = np.full(MEANS.shape, 5e-4)
SPEEDS, SIDES = np.array([5.0, 7.0, 9.0]), ("towards −y", "towards +y")

LOCATED = Located(
    horizons=np.array([0.1, 0.2, 0.3]),
    discrepancy=np.array([0.002, 0.006, 0.012]),
    shares={
        "flight": np.array([1.0, 0.5, 0.5]),
        "table": np.array([0.0, 0.5, 0.25]),
        "sensor": np.array([0.0, 0.0, 0.25]),
    },
    of_causes={"wind.x": np.array([1.0, 0.9, 0.8])},
    means=MEANS,
    margins=MARGINS,
    growth=(
        Growth("speed at launch", "m/s", SPEEDS, (), MEANS, MARGINS, 0.4, 2e-4),
        Growth("direction of play", "", np.arange(2.0), SIDES, MEANS[:2], MARGINS[:2], 0.4, 0.3),
    ),
    trend_horizon=0.3,
)


def cause(identity, unit, values, p_value, share, worth=None, also=(), **others):
    """A cause; ``values`` are the simulator's, the estimate, and the ends of its interval."""
    nominal, estimate, *interval = values
    parts = {
        "kind": "wrong_value" if nominal else "missing_effect",
        "unit": unit,
        "nominal": nominal,
        "estimate": estimate,
        "interval": interval,
        "p_value": p_value,
        "gap_share": share,
        "worth": worth and Worth(mm=worth[0], interval=worth[1:]),
        "possible": (identity, *also),
    }
    return Cause(identity=identity, **{**parts, **others})


WIND = cause("wind.x", "m/s", (0.0, 0.61, 0.59, 0.63), 5e-5, 0.7, (5.3, 2.8, 7.9))
GRAVITY = cause(
    "gravity.g", "m/s^2", (9.81, 10.3, 10.2, 10.4), 2e-4, 0.3, (-0.4, -1.1, 0.2), ["buoyancy.b"]
)
BENT = (0.0, 0.003, 0.002, 0.005)
CAMERA = cause("camera_distortion.amplitude", "m", BENT, 1e-6, 0.2, (2.0, 1.0, 3.0), role="sensor")
MINOR = cause("spin_decay.c", "1/m", (0.0, 0.003, 0.001, 0.005), 1e-3, 0.04, role="minor")
CAMERA_NODES = CameraNodes(
    length=0.8, nodes=((0.0, -1.0, 0.2, 1.0, 0.5, -0.5), (0.2, 1.0, 0.4, -1.0, 0.2, 0.8))
)
FITS = Check(name="prediction", ratio=1.05, interval=(0.9, 1.2), allowed=(0.75, 1.33))
MISFIT = Check(name="prediction", ratio=2.2, interval=(1.4, 3.2), allowed=(0.75, 1.33))
LABELS_MISFIT = Check(name="labels", ratio=0.62, interval=(0.62, 0.62), allowed=(0.0, 0.5))


def verdict(answer="named", causes=(WIND,), **changes):
    """A verdict with some causes; without any nothing arises anywhere."""
    parts = {
        "unexplained": Unexplained(share=0.0, p_value=0.4),
        "phases": PhaseShares(flight=1.0 if causes else 0.0, table=0.0, sensor=0.0),
        "gap": GAP,
        "checks": (FITS,),
        "minimum_detectable": {"wind.x": 0.04, "gravity.g": 0.06, "table_bounce.friction": 0.012},
        "not_identifiable": ("buoyancy.b", "spin_decay.c"),
        "limitations": ("all shots go in one direction",),
        "located": LOCATED if causes else None,
    }
    return Verdict(verdict=answer, causes=tuple(causes), **{**parts, **changes})


def diagnosed(found, simulator_name="mine", split=0):
    """A verdict as one of a case with four shots."""
    return CaseVerdict("lab", simulator_name, split, 4, found)


def findings(of=None, simulator_name="sim.yaml", name="lab"):
    """Findings with a verdict, on shots without spin labels that fly one way."""
    none = Shots.from_arrays([], [])
    measured = MeasuredShots(
        name,
        Shots.from_arrays([TIMES] * 4, [PATH] * 4),
        nets=NetContacts(none, none),
        recordings=5,
        refused={"not a number": 2},
        episodes=6,
        left_out={"broken": 1, "too short": 1},
        labels=LabelCounts(read=0, implausible=0, used=0),
        bounces=0,
        noise=0.003,
    )
    nominal = shipped("literature")
    return Findings(measured, nominal, simulator_name, DEFAULTS, of or verdict(), ANY_BALL)
