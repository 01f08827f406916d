"""How soon a change of the world is noticed in live forecasts.

Simulated sessions of the exam's shots: 100 in the simulator's world, then others, in which one
parameter has changed or none has. Sizes are in multiples of what 100 shots can show. Ten minutes on
two cores; writes ``reports/live/drift.json`` and its figure.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console

from experiments.benchmarks.comparison import ROOT
from experiments.exam.design.detection_limits import DetectionLimits
from experiments.exam.design.question import seed_of
from experiments.exam.interface import shots_of
from experiments.exam.simulate.recordings import simulate_trial
from experiments.exam.simulate.trial import Trial
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.live.drift import REFERENCE, DriftMonitor
from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.runtime.parallel import parallel
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH, apply_style, save_figure

SIMULATOR = load_simulator("literature")
QUIET_SESSIONS, QUIET_SHOTS = 25, 400  # without a change
SESSIONS, SHOTS = 20, 200  # of each cause and size
AT_ONCE = 20  # shots that are fitted together
SIZES = (1, 2, 4)  # detection limits
CAUSES = {
    "drag.cd": "worn ball: drag",
    "magnus.cm": "worn ball: lift",
    "wind.y": "air conditioner",
    "frame_tilt.x": "camera that was knocked",
    "clock_rate.d": "clock",
    "table_bounce.restitution": "table: restitution",
}
REPORT = ROOT / "reports" / "live" / "drift.json"


class Session(NamedTuple):
    """A session; its cause has a value after the reference, or there is none."""

    number: int
    shots: int
    cause: Hypothesis | None = None
    size: float = 0.0  # detection limits


def first_alarm(session: Session) -> tuple[int, str] | None:
    """Return the number of shots until the first alarm and what it names; None without any."""
    plain = Trial(
        "drift", SIMULATOR, shots=REFERENCE, seed=seed_of(session.number, "drift reference")
    )
    monitor = DriftMonitor(shots_of(simulate_trial(plain)[0]), SIMULATOR)
    causes: dict[str, dict[str, float]] = {}
    if session.cause is not None:
        (limit,) = DetectionLimits.of(plain).minimum_sizes((session.cause,))
        sign = 1 if session.number % 2 else -1
        value = session.cause.value(SIMULATOR) + sign * session.size * limit
        causes = {session.cause.effect: {session.cause.parameter: value}}
    seed = seed_of(session.number, "drift")
    changed = Trial("drift", SIMULATOR, causes=causes, shots=session.shots, seed=seed)
    shots = shots_of(simulate_trial(changed)[0])
    parts = (shots[k : k + AT_ONCE] for k in range(0, len(shots), AT_ONCE))
    alarms = enumerate((alarm for part in parts for alarm in monitor.add(part)), 1)
    return next(((k, alarm.hypothesis.identity) for k, alarm in alarms if alarm), None)


def sessions() -> Iterator[Session]:
    """Yield all sessions: without a change, then by cause and size."""
    for number in range(QUIET_SESSIONS):
        yield Session(number, QUIET_SHOTS)
    for identity in CAUSES:
        cause = Hypothesis.from_identity(identity)
        for size in SIZES:
            for number in range(SESSIONS):
                yield Session(number, SHOTS, cause, size)


def summary(asked: Sequence[Session], alarms: Sequence[tuple[int, str] | None]) -> dict[str, Any]:
    """Return the content of the report."""
    by_case: dict[tuple[str, float], list[tuple[int, str] | None]] = {}
    for session, alarm in zip(asked, alarms, strict=True):
        case = (session.cause.identity if session.cause else "", session.size)
        by_case.setdefault(case, []).append(alarm)
    quiet = by_case["", 0.0]
    return {
        "false_alarms": sum(alarm is not None for alarm in quiet),
        "shots": sum(QUIET_SHOTS if alarm is None else alarm[0] for alarm in quiet),
        "causes": {
            identity: {f"{size}x": _scores(by_case[identity, size], identity) for size in SIZES}
            for identity in CAUSES
        },
    }


def _scores(alarms: Sequence[tuple[int, str] | None], identity: str) -> dict[str, Any]:
    right = [alarm[0] if alarm and alarm[1] == identity else np.inf for alarm in alarms]
    median = float(np.median(right))
    return {
        "sessions": len(alarms),
        "alarms": sum(alarm is not None for alarm in alarms),
        "median_shots": median if np.isfinite(median) else None,
        "named_right": float(np.isfinite(right).mean()),
    }


def drift_figure(causes: dict[str, Any]) -> Figure:
    """Draw the median number of shots until a cause is named, and how often it is right."""
    figure = Figure(figsize=(FIGURE_WIDTH, 3.2))
    soon, right = figure.subplots(1, 2)
    for identity, label in CAUSES.items():
        scores = causes[identity].values()
        shots = [score["median_shots"] or np.nan for score in scores]
        soon.plot(SIZES, shots, marker="o", label=label)
        right.plot(SIZES, [100 * score["named_right"] for score in scores], marker="o")
    for axes in (soon, right):
        axes.set_xscale("log")
        axes.set_xticks(SIZES, [f"{size}" for size in SIZES])
        axes.minorticks_off()
        axes.set_xlabel("size of the change (detection limits of 100 shots)")
    soon.set_title("median shots until the right name")
    soon.set_ylim(bottom=0)
    right.set_title("alarms with the right name (% of sessions)")
    right.set_ylim(0, 105)
    figure.legend(*soon.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def main() -> None:
    """Measure, write, print."""
    asked = list(sessions())
    alarms = list(parallel([partial(first_alarm, session) for session in asked], "sessions"))
    content = summary(asked, alarms)
    write_json(REPORT, content)
    apply_style()
    save_figure(REPORT.with_suffix(".png"), drift_figure(content["causes"]))
    Console().print(content)


if __name__ == "__main__":
    main()
