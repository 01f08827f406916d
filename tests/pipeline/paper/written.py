"""Reports with chosen numbers, as the stages would leave them."""

import itertools

import pandas as pd

from pipeline.paper.prediction_accuracy import HORIZONS_MS, LEARNED, OTHERS, QUANTITIES, RIVALS
from pipeline.paper.run_reports import Reports


def write(root, file, rows):
    """Write a table of the reports; return them."""
    path = root / "reports" / file
    path.parent.mkdir(parents=True, exist_ok=True)
    pd.DataFrame(rows).to_csv(path, index=False)
    return Reports(root / "reports", {})


def errors(spread=None):
    """Mean errors of 40, and 20 of the transformer; standard deviations of their own."""
    spread = {LEARNED: 10.0} | (spread or {})
    keys = itertools.product([LEARNED, *RIVALS, *OTHERS], QUANTITIES, HORIZONS_MS)
    return [
        {
            "set": "arena", "against": "measured", "predictor": name, "quantity": quantity,
            "bounce": "all", "horizon_ms": horizon, "mean": 20.0 if name == LEARNED else 40.0,
            "std": spread.get(name, 30.0),
        }
        for name, quantity, horizon in keys
    ]  # fmt: skip


def differences(predictor=LEARNED, other="physics_c", mean=-20.0, half=5.0, lower_share=1.0):
    """Differences of all quantities at all shown horizons."""
    return [
        {
            "set": "arena", "predictor": predictor, "other": other, "quantity": quantity,
            "horizon_ms": horizon, "mean": mean, "ci_low": mean - half, "ci_high": mean + half,
            "lower_share": lower_share,
        }
        for quantity in QUANTITIES
        for horizon in HORIZONS_MS
    ]  # fmt: skip


def swap(times=1.25, half=0.05):
    """How many times the medians of physics those of the transformer are, of all metrics alike."""
    metrics = ("speed", "spin", "clearance", "win_probability")
    return [
        {
            "set": name, "horizons_ms": horizons, "predictor": "transformer",
            "protocol": "every_tick",
            **dict.fromkeys(metrics, times),
            **{f"{metric}_low": times - half for metric in metrics},
            **{f"{metric}_high": times + half for metric in metrics},
        }
        for name in ("stroke_pro", "stroke_uni", "receive")
        for horizons in ("115-125", "170-180")
    ]  # fmt: skip
