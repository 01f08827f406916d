"""Settings of a run, and of the code, in the form in which the paper prints them."""

from collections.abc import Callable, Collection

from rallygap.models.predictors.errors import HORIZONS_MS
from rallygap.models.predictors.protocol import FUTURE, HISTORY, TICK
from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS, STATE_COLUMNS
from rallygap.pipeline.paper.run_reports import Reports

SPLITS = "segment/splits.csv"
NETWORK, TRAINING = "train_predictor.networks.transformer", "train_predictor.training"
HORIZONS = "train_policy.groups.sim2sim.horizons_ms"
CANNON = "cannon"  # the group of the arena's episodes without players

Value = float | str | None

CONSTANTS: dict[str, float | str] = {
    "cameras": "one error for all",
    "history": HISTORY,
    "future": FUTURE,
    "tick_ms": 1000 * TICK,
    "furthest_ms": 1000 * TICK * FUTURE,
    "inputs": len(POSITION_COLUMNS) + len(SPIN_COLUMNS),
    "outputs": len(STATE_COLUMNS),
    "kernel": 3,
    "stride": 1,
    "first_horizon_ms": HORIZONS_MS[0],
    "last_horizon_ms": HORIZONS_MS[-1],
    "horizon_step_ms": HORIZONS_MS[1] - HORIZONS_MS[0],
}


def _episodes(run: Reports, column: str | None = None, values: Collection[str] = ()) -> Value:
    """Return how many of the arena's episodes have one of these values in a column."""
    table = run.table(SPLITS, ["source", *([column] if column else [])], ["episodes"])
    if table.empty:
        return None
    table = table[table["source"] == "arena"]
    chosen = table[table[column].isin(values)] if column else table
    return float(chosen["episodes"].sum())


def _players(run: Reports) -> list[str]:
    table = run.table(SPLITS, ["source", "group"], [])
    if table.empty:
        return []
    return sorted({*table.loc[table["source"] == "arena", "group"]} - {CANNON})


def _training_share(run: Reports) -> Value:
    training, validation = (_episodes(run, "split", [name]) for name in ("train", "validation"))
    if not isinstance(training, float) or not isinstance(validation, float):
        return None
    return training / (training + validation) if training and validation else None


def _optimizer(run: Reports) -> Value:
    training = run.param(TRAINING)
    if training is None:
        return None
    return "Adam" if training.get("matrix_learning_rate") is None else "Muon and Adam"


def _decay(run: Reports) -> Value:
    training = run.param(TRAINING)
    return None if training is None else training.get("decay") or "half a cosine"


def _future_rows(run: Reports) -> int | None:
    states = run.param(f"{NETWORK}.states_per_row")
    return None if states is None else FUTURE // int(states)


def _decoder_rows(run: Reports) -> Value:
    rows = _future_rows(run)
    return None if rows is None else HISTORY + rows


def _placeholders(run: Reports) -> Value:
    rows = _future_rows(run)
    if rows is None:
        return None
    uniform = run.param(f"{NETWORK}.uniform_motion")
    return f"{rows} rows of uniform motion" if uniform else f"{rows} x {CONSTANTS['inputs']} zeros"


def _horizons(run: Reports, index: int) -> Value:
    found = run.param(HORIZONS)
    return ", ".join(map(str, found[index])) if found and len(found) > index else None


# What is computed, and what it is computed from.
COMPUTED: dict[str, tuple[Callable[[Reports], Value], str]] = {
    "episodes": (_episodes, f"{SPLITS}: episodes"),
    "game_episodes": (lambda run: _episodes(run, "group", _players(run)), f"{SPLITS}: episodes"),
    "cannon_episodes": (lambda run: _episodes(run, "group", [CANNON]), f"{SPLITS}: episodes"),
    "test_episodes": (lambda run: _episodes(run, "split", ["test"]), f"{SPLITS}: episodes"),
    "training_share": (_training_share, f"{SPLITS}: episodes"),
    "player_levels": (lambda run: len(_players(run)) or None, f"{SPLITS}: group"),
    "decoder_rows": (_decoder_rows, f"params.yaml: {NETWORK}.states_per_row"),
    "placeholders": (_placeholders, f"params.yaml: {NETWORK}.states_per_row, uniform_motion"),
    "decay": (_decay, f"params.yaml: {TRAINING}.decay"),
    "optimizer": (_optimizer, f"params.yaml: {TRAINING}.matrix_learning_rate"),
    "near_horizons": (lambda run: _horizons(run, 0), f"params.yaml: {HORIZONS}"),
    "far_horizons": (lambda run: _horizons(run, 1), f"params.yaml: {HORIZONS}"),
}
