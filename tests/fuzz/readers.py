"""Every reader with a good file to damage, and how to read it."""

import json
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from experiments.exam.records import read_records, write_records
from rallygap.models.policy.observation import observation_size
from rallygap.pipeline.benchmark.forecasts import read_forecasts
from rallygap.pipeline.benchmark.windows import run_sets, window_table
from rallygap.pipeline.evaluation.example_shots import read_shots
from rallygap.pipeline.io.artifacts import read_as, write_json
from rallygap.pipeline.io.episodes import read_episodes
from rallygap.pipeline.io.ground_truth import read_contacts, read_truth
from rallygap.pipeline.io.schemas import LAUNCHES, RECORDINGS, checked
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.io.source_manifest import read_manifest
from rallygap.pipeline.paper.comparison import compare
from rallygap.pipeline.paper.run_reports import kept_reports
from rallygap.pipeline.params import load_params
from rallygap.pipeline.policies.storage import load_policy
from rallygap.pipeline.predictors.storage import load_predictor
from rallygap.pipeline.profiles import profile_flags
from rallygap.pipeline.runtime.provenance import provenance, short
from rallygap.pipeline.runtime.scratch import kept_timings
from rallygap.pipeline.sweeps.confirm import compared_params
from rallygap.pipeline.sweeps.report import BEST
from rallygap.pipeline.sweeps.settings import Sweep
from rallygap.pipeline.transfer.truth_comparison import NamedCauses
from rallygap.pipeline.web.pages import read_columns
from tests.experiments.exam.example_records import answer, hidden, named, record
from tests.fuzz import hostile
from tests.models.predictors.balls import observed
from tests.pipeline.benchmark.forecasting import ZeroPredictor, forecasts_of
from tests.pipeline.measured_shots import params, source_record, write_inputs, write_trained
from tests.pipeline.sources import made_up
from tests.pipeline.trained_policies import save_drawn

ROOT = Path(__file__).parents[2]
SWEEP = "experiments/profiles/sweeps/predictor.yaml"
BALL = [0.1, 1.3, 0.3, 0.2, -8.0, 0.5, -150.0, 10.0, 5.0]


@dataclass(frozen=True)
class Reader:
    """A reader under trial.

    Attributes:
        name: by which its tests are called.
        write: writes what it reads into a folder and returns the file to damage.
        read: reads it and uses what came of it; a number is of refused rows.
        hostile: files made for its format.
    """

    name: str
    write: Callable[[Path], Path]
    read: Callable[[Path], object]
    hostile: list[bytes]


def _source(name: str) -> Callable[[Path], int]:
    """Return what reads a source and counts what was refused of it."""

    def read(folder: Path) -> int:
        read = made_up.read(folder, name)
        checked(read.recordings, RECORDINGS)
        checked(read.launches, LAUNCHES)
        (record,) = read.manifest.sources.values()
        refused = sum(group.count for group in record.rows_refused.values())
        assert record.rows_read - record.rows_kept == refused
        return refused + sum(group.count for group in record.labels_refused.values())

    return read


def _write_described_csv(folder: Path) -> Path:
    frame = "frame:\n  rotation: [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]\n  offset: [0, 1.37, -0.76]\n"
    made_up.write_csv(folder, settings=f"name: lab\nrate: 143\nkind: cannon\n{frame}")
    return folder / "csv" / "source.yaml"


def _write_index(folder: Path) -> Path:
    made_up.write_spindoe(folder)
    return folder / "spindoe" / "index.csv"


def _copied(*names: str) -> Callable[[Path], Path]:
    """Return what copies files of the repository and returns the last."""

    def write(folder: Path) -> Path:
        for name in names:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
        return folder / names[-1]

    return write


def _json(name: str, content: object) -> Callable[[Path], Path]:
    """Return what writes a JSON file."""

    def write(folder: Path) -> Path:
        write_json(folder / name, content)
        return folder / name

    return write


def _write_simulator(folder: Path) -> Path:
    path = folder / "simulator.yaml"
    shutil.copy(ROOT / "models/ball/simulators/literature.yaml", path)
    return path


def _read_simulator(folder: Path) -> None:
    simulator = load_simulator(str(folder / "simulator.yaml"))
    assert np.isfinite(simulator.fly(BALL, [0.1, 0.2]).states).all()


def _write_best(folder: Path) -> Path:
    _copied("params.yaml", SWEEP)(folder)
    path = folder / "reports" / "sweeps" / "predictor" / BEST
    path.parent.mkdir(parents=True)
    path.write_text("train_predictor:\n  training:\n    learning_rate: 0.005\n    batch: 48\n")
    return path


def _write_predictor(file: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        write_trained(folder, "tiny")
        return folder / "artifacts" / "train_predictor" / "tiny" / file

    return write


def _huge_network() -> bytes:
    """A description that fits its contract, of a network of 20 GB."""
    huge = {"width": 4096, "expanded": 4096, "encoder_layers": 24, "decoder_layers": 24}
    with tempfile.TemporaryDirectory() as name:
        content = json.loads(_write_predictor("predictor.json")(Path(name)).read_text())
    content["network"] |= huge
    return json.dumps(content).encode()


def _read_predictor(folder: Path) -> None:
    predictor = load_predictor(folder / "artifacts" / "train_predictor" / "tiny")
    predictor.predict(observed(noise=0.003)[0])


def _write_policy(file: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        _, described = save_drawn(folder)
        return (folder / described.name).rename(folder / "policy") / file

    return write


def _read_policy(folder: Path) -> None:
    policy, described = load_policy(folder / "policy")
    goals, horizons = described.goals.count, len(described.horizons)
    size = observation_size(horizons, goals, described.observation)
    policy.act(np.zeros((2, size), np.float32))


CAUSE = {"identity": "wind.x", "interval": [0.1, 0.3], "unit": "m/s"}


def _write_records(folder: Path) -> Path:
    one = record(hidden(), answers=answer("named", named()))
    write_records(folder / "records.jsonl", [one, one])
    return folder / "records.jsonl"


FORECAST = {"t": [0.1, 0.2], "position": [[0.1, 1.0, 0.3], [0.1, 0.9, 0.3]]}
SHOT = {
    "episode_id": "plain/0/00", "source": "plain", "t": [0.0, 0.1], "anchor": 0.05,
    "measured": FORECAST["position"], "forecasts": {"tiny": FORECAST},
}  # fmt: skip


@cache
def _windows():
    with tempfile.TemporaryDirectory() as name:
        write_inputs(Path(name), sources=("plain",))
        return run_sets(Path(name), params())


def _write_forecasts(folder: Path) -> Path:
    path = folder / "forecasts.parquet"
    forecasts_of(ZeroPredictor(), window_table(_windows())).to_parquet(path, index=False)
    return path


def _read_forecasts(folder: Path) -> None:
    (forecast,) = read_forecasts(folder / "forecasts.parquet", _windows()).values()
    assert np.isfinite(forecast.states).all()


def _artifact(stage: str, name: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        write_inputs(folder, sources=("arena",))
        return folder / "artifacts" / stage / name

    return write


def _read_segmented(folder: Path) -> None:
    for one in read_episodes(folder / "artifacts" / "segment", {"arena"}):
        assert np.isfinite(one.episode.positions).all()


def _read_true_contacts(folder: Path) -> None:
    names = np.array(["arena/cannon/0", "arena/pro/2"])
    path = folder / "artifacts" / "ingest" / "true_contacts.parquet"
    for contacts in read_contacts(path, names).values():
        assert np.isfinite(contacts.states).all()


def _write_timings(folder: Path) -> Path:
    (folder / "dvc.yaml").write_text("stages: {segment: {cmd: a, deps: [params.yaml]}}")
    (folder / "params.yaml").write_text("seed: 1")
    present = short(provenance(folder, "segment").fingerprint)
    path = folder / "timings" / "segment" / f"{present}.json"
    write_json(path, {"tiny": {"training_s": 61.5}, "fitted_cpu_s_median": 3.25})
    return path


def _read_timings(folder: Path) -> None:
    for took in kept_timings(folder, "segment").values():
        assert all(map(np.isfinite, took.values() if isinstance(took, dict) else [took]))


def _of_format(hostile_files: list[bytes], *readers: tuple) -> list[Reader]:
    """Readers of one format, each a name and how its file is written and read."""
    return [Reader(*reader, [*hostile.NOTHING_GOOD, *hostile_files]) for reader in readers]


ISR, COMPETITIVE = "isr_ball_prediction", "competitive_robot_table_tennis"
PROFILE = "experiments/profiles/smoke.yaml"
PAPER = "reports/paper/params.json"
READERS = [
    *_of_format(
        hostile.SEPARATED,
        ("source csv", made_up.write_csv, _source("csv")),
        ("source spindoe", made_up.write_spindoe, _source("spindoe")),
        ("source spindoe, index.csv", _write_index, _source("spindoe")),
        ("source tt3d", made_up.write_tt3d, _source("tt3d")),
        (
            "report, tables",
            _copied("reports/segment/splits.csv"),
            lambda folder: read_columns(folder / "reports" / "segment" / "splits.csv"),
        ),
    ),
    *_of_format(
        hostile.YAML,
        ("source csv, source.yaml", _write_described_csv, _source("csv")),
        ("params.yaml", _copied("params.yaml"), lambda folder: load_params(folder / "params.yaml")),
        ("profile", _copied("params.yaml", PROFILE), lambda folder: profile_flags(folder, "smoke")),
        ("sweep", _copied("params.yaml", SWEEP), lambda folder: Sweep(folder, "predictor")),
        (
            "best_params.yaml",
            _write_best,
            lambda folder: compared_params(Sweep(folder, "predictor")),
        ),
        ("simulator", _write_simulator, _read_simulator),
    ),
    *_of_format(
        hostile.WEIGHTS,
        ("predictor, weights", _write_predictor("weights.safetensors"), _read_predictor),
        ("policy, weights", _write_policy("weights.safetensors"), _read_policy),
    ),
    *_of_format(hostile.HDF5, (f"source {ISR}", made_up.write_isr, _source(ISR))),
    *_of_format(
        [*hostile.JSON, _huge_network()],
        ("predictor, predictor.json", _write_predictor("predictor.json"), _read_predictor),
    ),
    *_of_format(
        hostile.JSON,
        (f"source {COMPETITIVE}", made_up.write_competitive, _source(COMPETITIVE)),
        ("policy, policy.json", _write_policy("policy.json"), _read_policy),
        (
            "verdict.json",
            _json("verdict.json", {"verdict": "named", "causes": [CAUSE, CAUSE]}),
            lambda folder: read_as(folder / "verdict.json", NamedCauses, "close_gap"),
        ),
        ("exam records", _write_records, lambda folder: read_records(folder / "records.jsonl")),
        (
            "manifest.json",
            _json("manifest.json", {"sources": {"plain": source_record("plain", "none")}}),
            lambda folder: read_manifest(folder / "manifest.json").labelled_once,
        ),
        (
            "truth.json",
            _artifact("ingest", "truth.json"),
            lambda folder: read_truth(folder / "artifacts" / "ingest" / "truth.json"),
        ),
        (
            "shots.json",
            _json("shots.json", [SHOT]),
            lambda folder: read_shots(folder / "shots.json"),
        ),
        ("timings", _write_timings, _read_timings),
        (
            "profile's run, params.json",
            _copied(PAPER),
            lambda folder: compare(kept_reports(folder / "reports" / "paper")),
        ),
    ),
    *_of_format(
        hostile.PARQUET,
        ("benchmark forecasts", _write_forecasts, _read_forecasts),
        *[
            (name, _artifact("segment", name), _read_segmented)
            for name in ("episodes.parquet", "contacts.parquet", "samples.parquet")
        ],
        (
            "true_contacts.parquet",
            _artifact("ingest", "true_contacts.parquet"),
            _read_true_contacts,
        ),
    ),
]
