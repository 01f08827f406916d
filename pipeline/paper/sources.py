"""Where our number comes from: a reader for each kind of source in ``values.csv``."""

from collections.abc import Callable, Collection, Mapping

from rallygap.models.ball.simulators import shipped
from rallygap.models.predictors.protocol import FUTURE, HISTORY
from rallygap.pipeline.paper.assessments import (
    FAILS,
    HOLDS,
    OPEN,
    Finding,
    Interval,
    claim,
    combined,
    difference,
)
from rallygap.pipeline.paper.run_reports import Reports, rows_with
from rallygap.pipeline.paper.values import Value, number, number_or_text

DIGITS = 4  # of a difference in percentage points: tables have six digits of a share
ERRORS = "evaluate_predictor/forecast_error.csv"
DIFFERENCES = "evaluate_predictor/forecast_error_difference.csv"
SET, LEARNED = "arena", "transformer"
HORIZONS_MS = (100, 200, 300)  # those that the tables of a run have
CASE: dict[str, str | int] = {"set": SET, "against": "measured", "bounce": "all"}  # of errors
SPLITS = "segment/splits.csv"
CANNON = "cannon"  # the group of the arena's episodes without players
NETWORK, TRAINING = "train_predictor.networks.transformer", "train_predictor.training"
HORIZONS = "train_policy.groups.sim2sim.horizons_ms"


def _table(value: Value, run: Reports, argument: str = "") -> Finding | None:
    """Return a number of a table of the reports, from the row that the argument names."""
    file, column = value.ours.split(": ")
    where = dict(part.split("=") for part in (argument or value.argument).split("; "))
    cells = run.numbers(file, [column, *value.ends.split()], **where)
    if cells is None:
        return None
    ours, *ends = (value.scale * (cell + value.offset) for cell in cells[:3])
    if not ends:
        return Finding(value=ours)
    interval = Interval(ours, *ends)
    if len(cells) == 3:
        return Finding(value=ours, interval=interval)
    counts = f"{round(cells[3], 1):g} of {cells[4]:.0f}"
    shown = f"{counts}: {number(ours)} % ({interval.low:.0f} to {interval.high:.0f})"
    return Finding("", ours, interval, shown)


def _difference(value: Value, run: Reports) -> Finding | None:
    """Return one number of a table minus another that is independent of it."""
    terms = [_table(value, run, argument) for argument in (value.argument, value.minus)]
    ends = [term.interval for term in terms if term is not None and term.interval is not None]
    if len(ends) < len(terms):
        return None
    interval = Interval(*(round(end, DIGITS) + 0.0 for end in difference(*ends)))  # no -0
    return Finding(value=interval.value, interval=interval)


def _parameter(value: Value, run: Reports) -> Finding | None:
    setting = run.param(value.ours.removeprefix("params.yaml: "))
    return None if setting is None else Finding(value=value.scale * float(setting))


def _constant(value: Value, run: Reports) -> Finding | None:
    """Return a constant of the code, the same in every run; a test compares it with the code."""
    return Finding(value=number_or_text(value.argument))


def _simulator(value: Value, run: Reports) -> Finding | None:
    """Return a parameter of a shipped simulator, named in the file or by a parameter of the run."""
    effect, parameter = value.argument.split(".")
    place, what = value.ours.split(": ")
    name = run.param(what) if place == "params.yaml" else place.split("/")[-1][: -len(".yaml")]
    return None if name is None else Finding(value=float(shipped(name).effects[effect][parameter]))


def _error(value: Value, run: Reports) -> Finding | None:
    """Return whether the transformer's mean error is below a rival's at every horizon.

    The number is the difference at the last horizon in percent of the rival's error.
    """
    quantity, rival = value.argument.split()
    pairs = [_error_difference(run, quantity, rival, horizon) for horizon in HORIZONS_MS]
    keys = {"predictor": rival, "quantity": quantity, "horizon_ms": HORIZONS_MS[-1], **CASE}
    last = run.numbers(ERRORS, ["mean"], **keys)
    known = [pair for pair in pairs if pair is not None]
    if len(known) < len(pairs) or last is None:
        return None
    word = combined(claim(interval, grows=False) for interval, _ in known)
    if word == HOLDS and min(lower for _, lower in known) < 1:
        word = OPEN
    interval = known[-1][0].times(100 / last[0])
    return Finding(word, interval.value, interval)


def _error_difference(
    run: Reports, quantity: str, rival: str, horizon: int
) -> tuple[Interval, float] | None:
    """Return the error minus the rival's, and at which share of horizons it is less.

    The table has a pair of predictors in either order.
    """
    at: dict[str, str | int] = {"set": SET, "quantity": quantity, "horizon_ms": horizon}
    names = ["mean", "ci_low", "ci_high", "lower_share"]
    for first, second, sign in ((LEARNED, rival, 1), (rival, LEARNED, -1)):
        numbers = run.numbers(DIFFERENCES, names, predictor=first, other=second, **at)
        if numbers is not None:
            *interval, lower = numbers
            return Interval(*interval).times(sign), lower if sign > 0 else 1 - lower
    return None


def _spread(value: Value, run: Reports) -> Finding | None:
    """Return whether the standard deviation of the error is below every rival's at all horizons.

    The number is the excess over the smallest of the rivals at the last horizon in percent.
    """
    quantity, *rivals = value.argument.split()
    table = run.table(ERRORS, ["quantity", "horizon_ms", "predictor", *CASE], ["std"])
    table = rows_with(table, {**CASE, "quantity": quantity})
    if not {LEARNED, *rivals} <= set(table.get("predictor", ())):
        return None
    spread = table.pivot(index="horizon_ms", columns="predictor", values="std")
    best = spread[rivals].min(axis=1)
    word = HOLDS if (spread[LEARNED] < best).all() else FAILS
    return Finding(word, 100 * float((spread[LEARNED] / best).iloc[-1] - 1))


def _computed(value: Value, run: Reports) -> Finding | None:
    result = COMPUTED[value.argument](run)
    return None if result is None else Finding(value=result)


def _episodes(run: Reports, column: str = "", values: Collection[str] = ()) -> float | None:
    """Return how many of the arena's episodes have one of these values in a column."""
    table = run.table(SPLITS, ["source", *([column] if column else [])], ["episodes"])
    if table.empty:
        return None
    table = rows_with(table, {"source": SET})
    chosen = table[table[column].isin(values)] if column else table
    return float(chosen["episodes"].sum())


def _players(run: Reports) -> list[str]:
    table = rows_with(run.table(SPLITS, ["source", "group"], []), {"source": SET})
    return sorted(set(table.get("group", ())) - {CANNON})


def _training_share(run: Reports) -> float | None:
    training, validation = (_episodes(run, "split", [name]) for name in ("train", "validation"))
    return training / (training + validation) if training and validation else None


def _training(run: Reports, key: str, missing: str, present: str = "") -> float | str | None:
    """Return a setting of the training, or what it means that it is missing or there."""
    training = run.param(TRAINING)
    if training is None:
        return None
    setting = training.get(key)
    return missing if setting is None else present or setting


def _decoder(run: Reports, *, placeholders: bool = False) -> float | str | None:
    """Return how many rows the decoder has, or what its rows of the future hold."""
    states = run.param(f"{NETWORK}.states_per_row")
    if states is None:
        return None
    rows = FUTURE // int(states)
    if not placeholders:
        return HISTORY + rows
    uniform = run.param(f"{NETWORK}.uniform_motion")
    return f"{rows} rows of uniform motion" if uniform else f"{rows} x 6 zeros"


def _horizons(run: Reports, index: int) -> str | None:
    horizons = run.param(HORIZONS)
    return ", ".join(map(str, horizons[index])) if horizons and len(horizons) > index else None


COMPUTED: Mapping[str, Callable[[Reports], float | str | None]] = {
    "episodes": _episodes,
    "game_episodes": lambda run: _episodes(run, "group", _players(run)),
    "cannon_episodes": lambda run: _episodes(run, "group", [CANNON]),
    "test_episodes": lambda run: _episodes(run, "split", ["test"]),
    "training_share": _training_share,
    "player_levels": lambda run: len(_players(run)) or None,
    "decoder_rows": _decoder,
    "placeholders": lambda run: _decoder(run, placeholders=True),
    "decay": lambda run: _training(run, "decay", "half a cosine"),
    "optimizer": lambda run: _training(run, "matrix_learning_rate", "Adam", "Muon and Adam"),
    "near_horizons": lambda run: _horizons(run, 0),
    "far_horizons": lambda run: _horizons(run, 1),
}
READERS: Mapping[str, Callable[[Value, Reports], Finding | None]] = {
    "table": _table,
    "difference": _difference,
    "parameter": _parameter,
    "constant": _constant,
    "simulator": _simulator,
    "error": _error,
    "spread": _spread,
    "computed": _computed,
    "nothing": lambda value, run: None,
}
