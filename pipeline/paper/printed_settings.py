"""What the paper prints of its data, its network, its training and its experiments."""

from collections.abc import Callable
from functools import partial
from typing import Annotated

from pydantic import AfterValidator, FiniteFloat, PositiveInt

from models.ball.simulators import shipped
from models.predictors.errors import HORIZONS_MS
from models.predictors.protocol import FUTURE, HISTORY, TICK
from pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS, STATE_COLUMNS
from pipeline.paper.entries import MISSING, Entry, Finding, Group
from pipeline.paper.judgements import NO_NUMBER, setting
from pipeline.paper.run_reports import Reports
from pipeline.paper.values import SHOTS

SPLITS = "segment/splits.csv"
ARENA, NETWORK = "ingest.arena", "train_predictor.networks.transformer"
TRAINING, POLICIES = "train_predictor.training", "train_policy.groups.sim2sim"
INPUTS, OUTPUTS = len(POSITION_COLUMNS) + len(SPIN_COLUMNS), len(STATE_COLUMNS)
SIMULATORS = {
    "ground_truth": ("ground truth", 0.55, 0.98),
    "imperfect_a": ("imperfect A", 0.55, 0.90),
    "imperfect_b": ("imperfect B", 0.40, 0.98),
    "imperfect_c": ("imperfect C", 0.40, 0.90),
}

Value = float | str | None


def _shipped(name: str) -> str:
    shipped(name)
    return name


Shipped = Annotated[str, AfterValidator(_shipped)]
"""The name of a shipped simulator."""


def _entry(
    key: str,
    what: str,
    printed: float | str,
    unit: str,
    stage: str,
    where: str,
    ours: Callable[[Reports], Value],
) -> Entry:
    def find(run: Reports) -> Finding:
        value = ours(run)
        return MISSING if value is None else Finding(setting(value, printed), value)

    return Entry(key, what, printed, unit, stage, where, find)


def _param(
    what: str,
    printed: float | str,
    unit: str,
    path: str,
    read: Callable[[float], float] = lambda value: value,
) -> Entry:
    """Return the entry of a parameter that is a number."""
    stage = path.split(".")[0]
    key = f"setting.{path}"

    def ours(run: Reports) -> Value:
        found = run.param(path, FiniteFloat)
        return None if found is None else read(found)

    return _entry(key, what, printed, unit, stage, f"params.yaml: {path}", ours)


def _constant(key: str, what: str, value: float | str, unit: str, stage: str, where: str,
              ours: float | str) -> Entry:  # fmt: skip
    """Return the entry of what no parameter changes."""
    return _entry(f"setting.{key}", what, value, unit, stage, where, lambda _: ours)


def _episodes(run: Reports, **columns: tuple[str, ...]) -> float | None:
    table = run.table(SPLITS, ["source", *columns], ["episodes"])
    if table.empty:
        return None
    table = table[table["source"] == "arena"]
    for column, values in columns.items():
        table = table[table[column].isin(values)]
    return float(table["episodes"].sum())


def _groups(run: Reports) -> list[str]:
    table = run.table(SPLITS, ["source", "group"], [])
    return sorted(set(table.loc[table["source"] == "arena", "group"])) if len(table) else []


def _players(run: Reports) -> tuple[str, ...]:
    return tuple(name for name in _groups(run) if name != "cannon")


def _learned_share(run: Reports) -> float | None:
    training, validation = (_episodes(run, split=(name,)) for name in ("train", "validation"))
    return training / (training + validation) if training and validation else None


def _of_simulator(name: str, effect: str, parameter: str) -> float:
    return float(shipped(name).effects[effect][parameter])


def _optimizer(run: Reports) -> Value:
    if run.param(TRAINING, dict) is None:
        return None
    rate = run.param(f"{TRAINING}.matrix_learning_rate", FiniteFloat)
    return "Adam" if rate is None else "Muon and Adam"


def _decay(run: Reports) -> Value:
    if run.param(TRAINING, dict) is None:
        return None
    return run.param(f"{TRAINING}.decay", FiniteFloat) or "half a cosine"


def _future_rows(run: Reports) -> int | None:
    """Return how many rows of the decoder stand for future states."""
    states = run.param(f"{NETWORK}.states_a_row", PositiveInt)
    return None if states is None else FUTURE // states


def _decoder_rows(run: Reports) -> Value:
    rows = _future_rows(run)
    return None if rows is None else HISTORY + rows


def _placeholders(run: Reports) -> Value:
    rows = _future_rows(run)
    if rows is None:
        return None
    told = run.param(f"{NETWORK}.uniform_motion", bool)
    return f"{rows} rows of uniform motion" if told else f"{rows} x {INPUTS} zeros"


def _replayed(name: str, run: Reports) -> Value:
    return run.number("sim2real/replayed.csv", "replayed", set=name)


def _horizons(at: int, run: Reports) -> Value:
    found = run.param(f"{POLICIES}.horizons_ms", list[list[int]])
    return ", ".join(map(str, found[at])) if found and len(found) > at else None


def _physics_of_transfer(effect: str, parameter: str, run: Reports) -> Value:
    name = run.param("sim2real.simulator", Shipped)
    return None if name is None else _of_simulator(name, effect, parameter)


SPLIT_EPISODES = f"{SPLITS}: episodes"

DATA = Group(
    "data",
    "The data",
    "Ours are simulated balls of the arena: sizes can be set beside the paper's, balls cannot.",
    None,
    (
        _entry("data.all", "ball trajectories, at least", 100_000, "episodes", "segment",
               SPLIT_EPISODES, _episodes),
        _entry("data.games", "episodes of games, about", 50_000, "episodes", "segment",
               SPLIT_EPISODES, lambda run: _episodes(run, group=_players(run))),
        _entry("data.cannon", "episodes of the ball cannon, about", 55_000, "episodes", "segment",
               SPLIT_EPISODES, lambda run: _episodes(run, group=("cannon",))),
        _entry("data.test", "test episodes, of games and cannon", 500, "episodes", "segment",
               SPLIT_EPISODES, lambda run: _episodes(run, split=("test",))),
        _entry("data.training", "share of the rest that is trained on", 0.9, "", "segment",
               SPLIT_EPISODES, _learned_share),
        _entry("data.levels", "levels of the players", 4, "", "segment", f"{SPLITS}: group",
               lambda run: len(_players(run)) or None),
        _param("sampling rate", 200, "Hz", f"{ARENA}.rate_hz"),
        _param("error of a measured position", 3, "mm", f"{ARENA}.position_noise",
               lambda metres: 1000 * metres),
        _param("error of a measured spin", 5, "%", f"{ARENA}.spin_noise",
               lambda share: 100 * share),
        _constant("cameras", "cameras", 6, "", "ingest", "models/arena/cameras.py",
                  "one error for all"),
    ),
)  # fmt: skip

PREDICTOR = Group(
    "predictor",
    "The network and its training",
    "",
    None,
    (
        _constant("history", "states in", 12, "", "train_predictor",
                  "models/predictors/protocol.py", HISTORY),
        _constant("future", "states out", 60, "", "train_predictor",
                  "models/predictors/protocol.py", FUTURE),
        _constant("tick", "between two of them", 5, "ms", "train_predictor",
                  "models/predictors/protocol.py", 1000 * TICK),
        _constant("furthest", "furthest forecast", 300, "ms", "train_predictor",
                  "models/predictors/protocol.py", 1000 * TICK * FUTURE),
        _constant("inputs", "numbers of a state in", 6, "", "train_predictor",
                  "models/predictors/protocol.py", INPUTS),
        _constant("outputs", "numbers of a state out", 9, "", "train_predictor",
                  "models/predictors/protocol.py", OUTPUTS),
        _constant("kernel", "kernel of the input convolution", 3, "", "train_predictor",
                  "models/predictors/transformer.py", 3),
        _constant("stride", "stride of the input convolution", 1, "", "train_predictor",
                  "models/predictors/transformer.py", 1),
        _entry("setting.decoder_rows", "rows of the decoder, of the past and of the future", 72,
               "", "train_predictor", f"params.yaml: {NETWORK}.states_a_row", _decoder_rows),
        _entry("setting.placeholders", "placeholders of the future", "60 x 6 zeros", "",
               "train_predictor", f"params.yaml: {NETWORK}.states_a_row, uniform_motion",
               _placeholders),
        _param("encoder layers", 3, "", f"{NETWORK}.encoder_layers"),
        _param("decoder layers", 2, "", f"{NETWORK}.decoder_layers"),
        _param("width of the layers", 512, "", f"{NETWORK}.width"),
        _param("channels inside a convolution block", 1024, "", f"{NETWORK}.expanded"),
        _param("attention heads", 8, "", f"{NETWORK}.heads"),
        _param("batch", 128, "", f"{TRAINING}.batch"),
        _param("epochs", 80, "", f"{TRAINING}.epochs"),
        _param("first learning rate", 0.0001, "", f"{TRAINING}.learning_rate"),
        _entry(f"setting.{TRAINING}.decay", "its factor after an epoch", 0.95, "",
               "train_predictor", f"params.yaml: {TRAINING}.decay", _decay),
        _constant("baseline_inputs", "TAE and GRU-TAE: numbers of a state in, 3 in their authors'",
                  6, "", "train_predictor", "models/predictors/normaliser.py", INPUTS),
        _constant("baseline_outputs",
                  "TAE and GRU-TAE: numbers of a state out, 3 in their authors'", 9, "",
                  "train_predictor", "models/predictors/normaliser.py", OUTPUTS),
        _entry("setting.optimizer", "optimizer", "Adam", "", "train_predictor",
               f"params.yaml: {TRAINING}.matrix_learning_rate", _optimizer),
    ),
)  # fmt: skip

EXPERIMENTS = Group(
    "experiments",
    "Simulators and experiments",
    "",
    None,
    (
        _constant("filtered", "physics baseline: states that the Kalman filter reads", 12, "",
                  "evaluate_predictor", "models/predictors/physics.py", HISTORY),
        _constant("judged.first", "forecasts are judged from", 100, "ms", "evaluate_predictor",
                  "models/predictors/errors.py", HORIZONS_MS[0]),
        _constant("judged.last", "forecasts are judged to", 300, "ms", "evaluate_predictor",
                  "models/predictors/errors.py", HORIZONS_MS[-1]),
        _constant("judged.every", "forecasts are judged every", 5, "ms", "evaluate_predictor",
                  "models/predictors/errors.py", HORIZONS_MS[1] - HORIZONS_MS[0]),
        *(
            _constant(f"{name}.{parameter}", f"{title}: {words}", value, "", "sim2sim",
                      f"models/ball/simulators/{name}.yaml: {effect}.{parameter}",
                      _of_simulator(name, effect, parameter))
            for name, (title, drag, restitution) in SIMULATORS.items()
            for words, effect, parameter, value in (
                ("drag coefficient", "drag", "cd", drag),
                ("restitution of the table", "table_bounce", "restitution", restitution),
            )
        ),
        _entry("setting.transfer.cd", "sim-to-real simulator: drag coefficient", 0.4, "",
               "sim2real", "params.yaml: sim2real.simulator",
               partial(_physics_of_transfer, "drag", "cd")),
        _entry("setting.transfer.restitution", "sim-to-real simulator: restitution of the table",
               0.9, "", "sim2real", "params.yaml: sim2real.simulator",
               partial(_physics_of_transfer, "table_bounce", "restitution")),
        *(
            _entry(f"setting.horizons.{at}", f"horizons that policies are told, {which}", text,
                   "ms", "train_policy", f"params.yaml: {POLICIES}.horizons_ms",
                   partial(_horizons, at))
            for at, (which, text) in enumerate(
                [("near", "115, 120, 125"), ("far", "170, 175, 180")]
            )
        ),
        _param("sim-to-sim: balls of an evaluation", 300, "", "sim2sim.episodes"),
        _param("sim-to-sim: trainings of a setting", 2, "", f"{POLICIES}.repeats"),
        *(
            _entry(f"setting.replayed.{name}", f"sim-to-real: shots of {name}", shots, "",
                   "sim2real", "sim2real/replayed.csv: replayed", partial(_replayed, name))
            for name, shots in SHOTS.items()
        ),
    ),
)  # fmt: skip


def _quoted(key: str, what: str, value: float | str, unit: str, where: str) -> Entry:
    return Entry(f"quoted.{key}", what, value, unit, "–", where, lambda _: Finding(NO_NUMBER))


QUOTED = Group(
    "quoted",
    "Numbers that the paper quotes from others",
    "Nothing here measures them; where the code stands to them is said instead.",
    None,
    (
        _quoted("speed", "fastest balls of professionals", 35, "m/s",
                "flight tested up to it: tests/models/ball"),
        _quoted("spin", "fastest spins", 1000, "rad/s",
                "flight tested up to it: tests/models/ball"),
        _quoted("reaction", "planning and reaction of dynamic robots", "100 to 200", "ms",
                "the horizons above; commands act at once: docs/deviations.md"),
        _quoted("small_sets", "sets of earlier work, measured and simulated",
                "200 and 330; 300 and 2000", "shots", "not used"),
    ),
)  # fmt: skip
