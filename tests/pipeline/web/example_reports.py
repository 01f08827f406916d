"""Made-up forecasts, shots and report folders, as the stages would leave them."""

from pathlib import Path

import numpy as np
import pandas as pd

from rallygap.pipeline.evaluation.example_shots import Forecast, Shot, read_shots, write_shots
from rallygap.pipeline.evaluation.figures.forecast_error import forecast_error_figure
from rallygap.pipeline.io.artifacts import write_json
from rallygap.pipeline.io.report_items import ReportAnimation
from rallygap.pipeline.io.report_manifest import read_contents
from rallygap.pipeline.paper.run_reports import Reports
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.transfer.example_returns import (
    Return,
    TimedForecast,
    read_returns,
    write_returns,
)
from rallygap.pipeline.web.report_page import render_page

COMMIT = "0123456789abcdef0123456789abcdef01234567"  # of experiments
HORIZONS = range(100, 301, 5)
WINDOWS = {"all": (1.0, 412), "with": (1.5, 168), "without": (0.6, 244)}
OFFSETS = {"physics_c": (0.03, 0.04, 0.0), "physics_literature": (0.0, 0.0, 0.08)}  # m


def forecast_errors(
    quantities=("position", "velocity", "spin"), windows=("all", "with", "without")
) -> pd.DataFrame:
    """Errors that grow with the horizon, one row a predictor, quantity, window and horizon."""
    rows = []
    for factor, predictor in enumerate(OFFSETS, start=1):
        for quantity in quantities:
            for window in windows:
                size, count = WINDOWS[window]
                for horizon in HORIZONS:
                    mean = factor * size * (horizon / 100) ** 2
                    key = ("spindoe", predictor, quantity, horizon, window)
                    rows.append((*key, mean, 0.6 * mean, count, 0.9 * mean, 1.1 * mean))
    columns = "set predictor quantity horizon_ms bounce mean std n ci_low ci_high"
    return pd.DataFrame(rows, columns=columns.split())


def learning_curves() -> pd.DataFrame:
    """Errors in mm of three predictors by the number of recordings."""
    errors = {"amended_imperfect_c": 30.0, "transformer": 90.0, "oracle": 28.0}
    rows = [
        (name, recordings, 300, mean + 300 / recordings)
        for name, mean in errors.items()
        for recordings in (10, 300, 2000)
    ]
    return pd.DataFrame(rows, columns=["predictor", "recordings", "horizon_ms", "mean"])


def bouncing_ball(times: np.ndarray) -> np.ndarray:
    """Positions (T, 3) of a ball in vacuum that meets the table elastically at 0.02 m."""
    fall = 0.30 + 1.0 * times - 9.81 / 2 * times**2
    landing = (1.0 + np.sqrt(1 + 2 * 9.81 * 0.28)) / 9.81
    after = times - landing
    rise = 0.02 + (9.81 * landing - 1.0) * after - 9.81 / 2 * after**2
    height = np.where(times < landing, fall, rise)
    return np.column_stack([0.3 - 0.5 * times, 1.5 - 4.5 * times, height])


def made_up_shots(names=("spindoe/000/00", "spindoe/001/00")) -> list[Shot]:
    """Shots whose forecasts are off by a fixed distance: 50 mm and 80 mm."""
    times = np.arange(0.0, 0.6, 0.005)
    after = times[12:72]
    forecasts = {
        name: Forecast(t=after.tolist(), position=(bouncing_ball(after) + offset).tolist())
        for name, offset in OFFSETS.items()
    }
    measured = {"t": times.tolist(), "measured": bouncing_ball(times).tolist()}
    return [
        Shot(episode_id=name, source="spindoe", anchor=times[11], forecasts=forecasts, **measured)
        for name in names
    ]


def made_up_return(**changes) -> Return:
    """A ball that the arm meets after 0.5 s and sends back; forecasts are 50 and 80 mm off."""
    times = np.arange(0.0, 0.9001, 0.005)
    coming = bouncing_ball(np.minimum(times, 0.5))
    coming[:, 1] += 4.0 * np.maximum(times - 0.5, 0.0)
    ball = Forecast(t=times.round(6).tolist(), position=coming.tolist())
    before = times[times <= 0.5]
    plain = {
        "name": "stroke_pro 3",
        "predictor": "physics",
        "outcome": "returned",
        "horizon": 0.12,
        "hit": 0.5,
        "measured": Forecast(t=before.tolist(), position=bouncing_ball(before).tolist()),
        "ball": ball,
        "frame": 0.02,
        "joints": [(0.1 * s, 0.0, 0.2 * s, 0.0, 0.0, 0.1 * s) for s in np.linspace(0, 1, 46)],
        "forecasts": {name: _timed(offset) for name, offset in OFFSETS.items()},
    }
    return Return(**{**plain, **changes})


def _timed(offset: tuple[float, float, float]) -> list[TimedForecast]:
    """Forecasts at 55, 95, ... ms."""
    timed = []
    for at in np.arange(0.055, 0.5, 0.04).round(6):
        ahead = (at + np.arange(0.02, 0.301, 0.02)).round(6)
        places = (bouncing_ball(ahead) + offset).tolist()
        timed.append(TimedForecast(at=at, track=Forecast(t=ahead.tolist(), position=places)))
    return timed


def moving_dot() -> list[np.ndarray]:
    """Pictures (40, 60, 3) of a white square that crosses them."""
    frames = np.zeros((5, 40, 60, 3), dtype=np.uint8)
    for step, frame in enumerate(frames):
        frame[15:25, 10 * step : 10 * step + 10] = 255
    return list(frames)


def write_stage(root: Path, stage: str, items: list[dict[str, str]]) -> None:
    """Write a stage's contents.json."""
    command = f"python -m stages.{stage}"
    content = {"stage": stage, "command": command, "fingerprint": "3fa9c1d20b77", "items": items}
    write_json(root / "reports" / stage / "contents.json", content)


def make_reports(root: Path, title: str = "Contacts", shot: str = "spindoe/000/00") -> None:
    """Fill ``root`` with the reports and artefacts that the page is made of."""
    reports = root / "reports"
    (reports / "ingest").mkdir(parents=True)
    (reports / "segment").mkdir()
    (reports / "evaluate_predictor" / "figures").mkdir(parents=True)
    _write_sources(reports / "ingest" / "sources.csv")
    contacts = pd.DataFrame({"recording": [title, "tt3d/003"], "speed_change": [12.3456, 0.5]})
    contacts.to_csv(reports / "segment" / "contacts.csv", index=False)
    figure = forecast_error_figure(forecast_errors(["position"], ["all"]))
    figure.savefig(reports / "evaluate_predictor" / "figures" / "spindoe.png")
    figure.savefig(reports / "learning_curves.png")
    write_json(reports / "learning_curves.json", {"commit": COMMIT})
    learning_curves().to_csv(reports / "learning_curves.csv", index=False)
    run = StageRun("evaluate_predictor", root, params=None)
    run.add(ReportAnimation(moving_dot(), "ball", title="Ball", caption=""))
    _write_all_contents(root, title)
    write_shots(
        root / "artifacts" / "evaluate_predictor" / "shots.json",
        made_up_shots((shot, "spindoe/001/00")),
    )
    returns = [made_up_return(), made_up_return(outcome="missed", hit=None)]
    write_returns(root / "artifacts" / "sim2real" / "returns.json", returns)


def made_up_page(root: Path) -> str:
    """The page of a folder that ``make_reports`` filled."""
    stages = ["ingest", "segment", "evaluate_predictor", "sim2real"]
    contents = [read_contents(root / "reports", stage) for stage in stages]
    shots = read_shots(root / "artifacts" / "evaluate_predictor" / "shots.json")
    returns = read_returns(root / "artifacts" / "sim2real" / "returns.json")
    return render_page(Reports(root / "reports", {}), contents, shots, returns)


def _write_sources(path: Path) -> None:
    wide = {f"a_rather_long_column_{number}": np.arange(40) * number for number in range(12)}
    pd.DataFrame({"source": ["spindoe"] * 40, **wide}).to_csv(path, index=False)


def _write_all_contents(root: Path, title: str) -> None:
    sources = {"file": "sources.csv", "title": "Sources", "caption": "Rows read and refused."}
    contacts = {"file": "contacts.csv", "title": title, "caption": f"Contacts of {title}."}
    errors = {
        "file": "figures/spindoe.png",
        "title": "Forecast error on spindoe",
        "caption": "Mean error and its interval from 100 to 300 ms, with and without a bounce.",
    }
    write_stage(root, "ingest", [{"kind": "table", **sources}])
    write_stage(root, "segment", [{"kind": "table", **contacts}])
    for stage in ("score_segmentation", "train_predictor", "train_policy", "sim2sim", "sim2real"):
        write_stage(root, stage, [])
    for stage in ("close_gap", "shot_quality", "retrain_policy", "hidden_effects"):
        write_stage(root, stage, [])
    ball = {"file": "figures/ball.png", "title": "Ball", "caption": "A square crosses the picture."}
    items = [{"kind": "figure", **errors}, {"kind": "animation", **ball}]
    write_stage(root, "evaluate_predictor", items)
