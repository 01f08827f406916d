"""How good returns are: the paper's figure of shot quality, claim by claim."""

from functools import partial
from typing import NamedTuple

from pipeline.paper.entries import MISSING, Entry, Finding, Group
from pipeline.paper.judgements import Interval, claim, within
from pipeline.paper.run_reports import Reports
from pipeline.paper.transfer import HORIZONS_MS, PREDICTORS, SETS

SWAP = "shot_quality/swap.csv"
TWICE = (1.5, 2.5)  # what counts as about twice as much


class Metric(NamedTuple):
    """A property of returns, and which way the paper says that the swap moves it."""

    title: str
    grows: bool

    @property
    def direction(self) -> str:
        """In a word."""
        return "higher" if self.grows else "lower"


METRICS = {
    "speed": Metric("ball speed", True),
    "spin": Metric("spin rate", True),
    "clearance": Metric("clearance over the net", False),
    "win_probability": Metric("winning probability", True),
}


def _times(name: str, horizons: str, metric: str, run: Reports) -> Interval | None:
    """Return how many times the median with physics the one with the transformer is."""
    return run.interval(
        SWAP,
        metric,
        (f"{metric}_low", f"{metric}_high"),
        set=name,
        horizons_ms=horizons,
        predictor=PREDICTORS["learned"],
        protocol="every_tick",
    )


def _moved(name: str, horizons: str, metric: str, run: Reports) -> Finding:
    times = _times(name, horizons, metric, run)
    if times is None:
        return MISSING
    change = Interval(*(100 * (end - 1) for end in times))
    return Finding(claim(change, grows=METRICS[metric].grows), change.value, change)


def _doubled(name: str, run: Reports) -> Finding:
    times = _times(name, HORIZONS_MS[0], "win_probability", run)
    if times is None:
        return MISSING
    return Finding(within(times, *TWICE), times.value, times)


def _entry(name: str, horizons: str, metric: str) -> Entry:
    moved = METRICS[metric]
    return Entry(
        f"quality.{metric}.{name}.{horizons}",
        f"{SETS[name]}, {horizons} ms: median {moved.title} {moved.direction} after the swap",
        None,
        "%",
        "shot_quality",
        f"{SWAP}: {metric}, {metric}_low, {metric}_high",
        partial(_moved, name, horizons, metric),
        words=moved.direction,
    )


QUALITY = Group(
    "quality",
    "Figure 5: shot quality",
    "Medians over the returns told by the transformer minus those told by physics, in percent of "
    "the latter, with the interval over the balls, the same ones for both. How many returns are "
    "unlike all shots that the forest has learned from: unlike, in shot_quality/quality.csv.",
    (-100.0, 100.0),
    tuple(
        _entry(name, horizons, metric)
        for metric in METRICS
        for name in SETS
        for horizons in HORIZONS_MS
    ),
)

DOUBLED = Group(
    "doubled",
    "Figure 5: winning probability about doubled",
    "Medians with the transformer over those with physics. About twice is from "
    f"{TWICE[0]} to {TWICE[1]} times: the claim holds where the whole interval lies within, and "
    "fails where all of it lies outside.",
    (0.0, 4.0),
    tuple(
        Entry(
            f"quality.doubled.{name}",
            f"{SETS[name]}, {HORIZONS_MS[0]} ms: winning probability after the swap",
            2,
            "times",
            "shot_quality",
            f"{SWAP}: win_probability, win_probability_low, win_probability_high",
            partial(_doubled, name),
            words="about twice",
        )
        for name in ("stroke_uni", "stroke_pro")
    ),
)
