"""Made-up forecasts, shots and report folders, as the stages would leave them."""

from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from rallygap.pipeline.evaluation.example_shots import Forecast, Shot, read_shots, write_shots
from rallygap.pipeline.io.artifacts import write_csv
from rallygap.pipeline.paper.run_reports import Reports
from rallygap.pipeline.report.page import render_page
from rallygap.pipeline.transfer.shown_returns import (
    Return,
    TimedForecast,
    read_returns,
    write_returns,
)
from rallygap.pipeline.web.figure_style import FIGURE_WIDTH
from rallygap.pipeline.web.report_items import (
    ReportAnimation,
    ReportFigure,
    ReportItem,
    ReportTable,
    Written,
)

Items = dict[str, list[Written]]  # by stage
HORIZONS = range(100, 301, 5)
WINDOWS = {"all": (1.0, 412), "with": (1.5, 168), "without": (0.6, 244)}
OFFSETS = {"physics_c": (0.03, 0.04, 0.0), "physics_literature": (0.0, 0.0, 0.08)}  # m


def forecast_errors() -> pd.DataFrame:
    """Errors that grow with the horizon, one row a predictor, quantity, window and horizon."""
    quantities = ("position", "velocity", "spin")
    keys = product(["spindoe"], OFFSETS, quantities, HORIZONS, WINDOWS)
    table = pd.DataFrame(keys, columns=["set", "predictor", "quantity", "horizon_ms", "bounce"])
    table["n"] = table["bounce"].map({name: count for name, (_, count) in WINDOWS.items()})
    sizes = table["bounce"].map({name: size for name, (size, _) in WINDOWS.items()})
    mean = sizes * (table["predictor"].map(list(OFFSETS).index) + 1)
    mean *= (table["horizon_ms"] / 100) ** 2
    return table.assign(mean=mean, std=0.6 * mean, ci_low=0.9 * mean, ci_high=1.1 * mean)


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
    forecasts = {name: _track(after, offset) for name, offset in OFFSETS.items()}
    measured = {"t": times.tolist(), "measured": bouncing_ball(times).tolist()}
    return [
        Shot(episode_id=name, source="spindoe", anchor=times[11], forecasts=forecasts, **measured)
        for name in names
    ]


def made_up_return(outcome: str = "returned", hit: float | None = 0.5) -> Return:
    """A ball that the arm meets after 0.5 s and sends back; forecasts are 50 and 80 mm off."""
    times = np.arange(0.0, 0.9001, 0.005)
    coming = bouncing_ball(np.minimum(times, 0.5))
    coming[:, 1] += 4.0 * np.maximum(times - 0.5, 0.0)
    ball = Forecast(t=times.round(6).tolist(), position=coming.tolist())
    return Return(
        name="stroke_pro 3",
        predictor="physics",
        outcome=outcome,
        horizon=0.12,
        hit=hit,
        measured=_track(times[times <= 0.5]),
        ball=ball,
        frame=0.02,
        joints=[(0.1 * s, 0.0, 0.2 * s, 0.0, 0.0, 0.1 * s) for s in np.linspace(0, 1, 46)],
        forecasts={name: _timed(offset) for name, offset in OFFSETS.items()},
    )


def _timed(offset: tuple[float, float, float]) -> list[TimedForecast]:
    """Forecasts at 55, 95, ... ms."""
    starts = np.arange(0.055, 0.5, 0.04).round(6)
    return [
        TimedForecast(at=at, track=_track((at + np.arange(0.02, 0.301, 0.02)).round(6), offset))
        for at in starts
    ]


def _track(times: np.ndarray, offset: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Forecast:
    return Forecast(t=times.tolist(), position=(bouncing_ball(times) + offset).tolist())


def moving_dot() -> list[np.ndarray]:
    """Pictures (40, 60, 3) of a white square that crosses them."""
    frames = np.zeros((5, 40, 60, 3), dtype=np.uint8)
    for step, frame in enumerate(frames):
        frame[15:25, 10 * step : 10 * step + 10] = 255
    return list(frames)


def make_reports(root: Path, title: str = "Contacts", shot: str = "spindoe/000/00") -> Items:
    """Fill ``root`` with the reports and artefacts that the page is made of; return the items."""
    reports = root / "reports"
    figure = Figure(figsize=(FIGURE_WIDTH, 1.0))
    figure.subplots().plot(HORIZONS)
    errors = {"amended_imperfect_c": 31.0, "transformer": 90.0, "oracle": 28.0}
    curves = pd.DataFrame(errors.items(), columns=["predictor", "mean"])
    curves = curves.assign(recordings=[300, 2000, 2000], horizon_ms=300)
    write_csv(reports / "learning_curves" / "errors.csv", curves)
    contacts = pd.DataFrame({"recording": [title, "tt3d/003"], "speed_change": [12.3456, 0.5]})
    caption = "Mean error and its interval from 100 to 300 ms, with and without a bounce."
    wide = {f"a_rather_long_column_{number}": np.arange(40) * number for number in range(12)}
    sources = pd.DataFrame({"source": "spindoe", **wide})
    items: dict[str, list[ReportItem]] = {
        "ingest": [ReportTable(sources, "sources", "Sources", "Rows read and refused.")],
        "segment": [ReportTable(contacts, "contacts", title, f"Contacts of {title}.")],
        "evaluate_predictor": [
            ReportFigure(figure, "spindoe", "Forecast error on spindoe", caption),
            ReportAnimation(moving_dot(), "ball", "Ball", "A square crosses the picture."),
        ],
        "learning_curves": [ReportFigure(figure, "errors", "Learning curves", caption)],
        "sim2real": [],
    }
    for stage, members in items.items():
        for item in members:
            item.write(reports / stage / item.file)
    shots = made_up_shots((shot, "spindoe/001/00"))
    write_shots(root / "artifacts" / "evaluate_predictor" / "shots.json", shots)
    returns = [made_up_return(), made_up_return(outcome="missed", hit=None)]
    write_returns(root / "artifacts" / "sim2real" / "returns.json", returns)
    return {
        stage: [Written(item.kind, item.file, item.title, item.caption) for item in members]
        for stage, members in items.items()
    }


def made_up_page(root: Path, items: Items) -> str:
    """The page of a folder that ``make_reports`` filled with these items."""
    shots = read_shots(root / "artifacts" / "evaluate_predictor" / "shots.json")
    returns = read_returns(root / "artifacts" / "sim2real" / "returns.json")
    return render_page(Reports(root / "reports", {}), items, shots, returns)
