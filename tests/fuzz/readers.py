"""Every reader with a good file to damage, and how to read it."""

import json
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from rallygap.models.policy.observation import observation_size
from rallygap.pipeline.benchmark.forecasts import read_forecasts
from rallygap.pipeline.benchmark.windows import run_sets, window_table
from rallygap.pipeline.evaluation.error_table import REPORT as FORECAST_ERRORS
from rallygap.pipeline.evaluation.error_table import read_errors
from rallygap.pipeline.evaluation.example_shots import read_shots
from rallygap.pipeline.exam.records import read_records, write_records
from rallygap.pipeline.experiments.profiles import profile_flags
from rallygap.pipeline.io.artifacts import read_as, write_json
from rallygap.pipeline.io.episodes import read_episodes
from rallygap.pipeline.io.ground_truth import read_contacts, read_truth
from rallygap.pipeline.io.schemas import LAUNCHES, RECORDINGS, checked
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.io.source_manifest import read_manifest
from rallygap.pipeline.paper.comparison import compare
from rallygap.pipeline.paper.run_reports import kept_reports
from rallygap.pipeline.params import load_params
from rallygap.pipeline.policies.storage import TrainedPolicy, load_policy
from rallygap.pipeline.predictors.storage import load_predictor
from rallygap.pipeline.runtime.provenance import provenance, short
from rallygap.pipeline.runtime.scratch import kept_timings
from rallygap.pipeline.sweeps.confirm import compared_params
from rallygap.pipeline.sweeps.report import BEST
from rallygap.pipeline.sweeps.settings import load_sweep
from rallygap.pipeline.transfer.truth_comparison import NamedCauses
from rallygap.pipeline.web.pages import read_columns
from tests.fuzz import hostile
from tests.models.exam.example_records import answer, hidden, named, record
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
        name: in the table of counts.
        write: writes what it reads into a folder and returns the file to damage.
        read: reads it, uses what came of it, and returns how many rows were refused.
        hostile: files made for its format.
    """

    name: str
    write: Callable[[Path], Path]
    read: Callable[[Path], int]
    hostile: list[bytes]


def _source(name: str, folder: Path) -> int:
    """Read a source; count what was refused of it."""
    read = made_up.read(folder, name)
    checked(read.recordings, RECORDINGS)
    checked(read.launches, LAUNCHES)
    (record,) = read.manifest.sources.values()
    refused = sum(group.count for group in record.rows_refused.values())
    assert record.rows_read - record.rows_kept == refused
    return refused + sum(group.count for group in record.labels_refused.values())


def _source_reader(
    name: str, source: str, write: Callable[[Path], Path], hostile_files: list[bytes]
) -> Reader:
    return Reader(name, write, lambda folder: _source(source, folder), hostile_files)


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


def _read_params(folder: Path) -> int:
    load_params(folder / "params.yaml")
    return 0


def _read_profile(folder: Path) -> int:
    profile_flags(folder, "smoke")
    return 0


def _write_simulator(folder: Path) -> Path:
    path = folder / "simulator.yaml"
    shutil.copy(ROOT / "models/ball/simulators/literature.yaml", path)
    return path


def _read_simulator(folder: Path) -> int:
    simulator = load_simulator(str(folder / "simulator.yaml"))
    assert np.isfinite(simulator.fly(BALL, [0.1, 0.2]).states).all()
    return 0


def _read_sweep(folder: Path) -> int:
    load_sweep(folder, "predictor")
    return 0


def _write_best(folder: Path) -> Path:
    _copied("params.yaml", SWEEP)(folder)
    path = folder / "reports" / "sweeps" / "predictor" / BEST
    path.parent.mkdir(parents=True)
    path.write_text("train_predictor:\n  training:\n    learning_rate: 0.005\n    batch: 48\n")
    return path


def _read_best(folder: Path) -> int:
    compared_params(load_sweep(folder, "predictor"))
    return 0


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


def _read_predictor(folder: Path) -> int:
    predictor = load_predictor(folder / "artifacts" / "train_predictor" / "tiny")
    history, _ = observed(noise=0.003)
    predictor.predict(history)
    return 0


def _write_policy(file: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        _, described = save_drawn(folder)
        return (folder / described.name).rename(folder / "policy") / file

    return write


def _inputs(described: TrainedPolicy) -> int:
    goals, horizons = described.goals.count, len(described.horizons)
    return observation_size(horizons, goals, described.observation)


def _read_policy(folder: Path) -> int:
    policy, described = load_policy(folder / "policy")
    policy.act(np.zeros((2, _inputs(described)), np.float32))
    return 0


def _write_verdict(folder: Path) -> Path:
    cause = {"identity": "wind.x", "interval": [0.1, 0.3], "unit": "m/s"}
    write_json(folder / "verdict.json", {"verdict": "named", "causes": [cause, cause]})
    return folder / "verdict.json"


def _read_verdict(folder: Path) -> int:
    read_as(folder / "verdict.json", NamedCauses, "close_gap")
    return 0


def _write_records(folder: Path) -> Path:
    one = record(hidden(), answers=answer("named", named()))
    write_records(folder / "records.jsonl", [one, one])
    return folder / "records.jsonl"


def _read_records(folder: Path) -> int:
    read_records(folder / "records.jsonl")
    return 0


def _write_manifest(folder: Path) -> Path:
    write_json(folder / "manifest.json", {"sources": {"plain": source_record("plain", "none")}})
    return folder / "manifest.json"


def _read_manifest(folder: Path) -> int:
    manifest = read_manifest(folder / "manifest.json")
    assert all(isinstance(name, str) for name in manifest.labelled_once)
    return 0


def _write_truth(folder: Path) -> Path:
    write_inputs(folder, sources=("arena",))
    return folder / "artifacts" / "ingest" / "truth.json"


def _read_truth(folder: Path) -> int:
    read_truth(folder / "artifacts" / "ingest" / "truth.json")
    return 0


def _write_shots(folder: Path) -> Path:
    forecast = {"t": [0.1, 0.2], "position": [[0.1, 1.0, 0.3], [0.1, 0.9, 0.3]]}
    shot = {"episode_id": "plain/0/00", "source": "plain", "t": [0.0, 0.1], "anchor": 0.05}
    measured = {"measured": forecast["position"], "forecasts": {"tiny": forecast}}
    write_json(folder / "shots.json", [{**shot, **measured}])
    return folder / "shots.json"


def _read_shots(folder: Path) -> int:
    read_shots(folder / "shots.json")
    return 0


def _write_columns(folder: Path) -> Path:
    return _copied("reports/segment/splits.csv")(_made(folder / "reports"))


def _made(folder: Path) -> Path:
    folder.mkdir()
    return folder.parent


def _read_columns(folder: Path) -> int:
    read_columns(folder / "reports" / "segment" / "splits.csv")
    return 0


@cache
def _windows():
    with tempfile.TemporaryDirectory() as name:
        write_inputs(Path(name), sources=("plain",))
        return run_sets(Path(name), params())


def _write_forecasts(folder: Path) -> Path:
    path = folder / "forecasts.parquet"
    forecasts_of(ZeroPredictor(), window_table(_windows())).to_parquet(path, index=False)
    return path


def _read_forecasts(folder: Path) -> int:
    (forecast,) = read_forecasts(folder / "forecasts.parquet", _windows()).values()
    assert np.isfinite(forecast.states).all()
    return 0


def _read_errors(folder: Path) -> int:
    errors = read_errors(folder)
    assert np.isfinite(errors.select_dtypes("number").to_numpy()).all()
    return 0


def _write_table(stage: str, name: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        write_inputs(folder, sources=("arena",))
        return folder / "artifacts" / stage / name

    return write


def _read_segmented(folder: Path) -> int:
    for one in read_episodes(folder / "artifacts" / "segment", {"arena"}):
        assert np.isfinite(one.episode.positions).all()
    return 0


def _read_true_contacts(folder: Path) -> int:
    names = np.array(["arena/cannon/0", "arena/pro/2"])
    path = folder / "artifacts" / "ingest" / "true_contacts.parquet"
    for contacts in read_contacts(path, names).values():
        assert np.isfinite(contacts.states).all()
    return 0


def _write_timings(folder: Path) -> Path:
    stage = "stages: {segment: {cmd: a, deps: [params.yaml], params: [seed]}}"
    (folder / "dvc.yaml").write_text(stage)
    (folder / "params.yaml").write_text("seed: 1")
    present = short(provenance(folder, "segment").fingerprint)
    path = folder / "timings" / "segment" / f"{present}.json"
    write_json(path, {"tiny": {"training_s": 61.5}, "fitted_cpu_s_median": 3.25})
    return path


def _read_timings(folder: Path) -> int:
    for took in kept_timings(folder, "segment").values():
        assert all(map(np.isfinite, took.values() if isinstance(took, dict) else [took]))
    return 0


def _read_kept_run(folder: Path) -> int:
    compare(kept_reports(folder / "reports" / "paper"))
    return 0


SEPARATED = [*hostile.NOTHING_GOOD, *hostile.SEPARATED]
YAML = [*hostile.NOTHING_GOOD, *hostile.YAML]
JSON = [*hostile.NOTHING_GOOD, *hostile.JSON]
WEIGHTS = [*hostile.NOTHING_GOOD, *hostile.WEIGHTS]
PARQUET = [*hostile.NOTHING_GOOD, *hostile.PARQUET]

READERS = [
    _source_reader("source csv", "csv", made_up.write_csv, SEPARATED),
    _source_reader("source csv, source.yaml", "csv", _write_described_csv, YAML),
    _source_reader("source spindoe", "spindoe", made_up.write_spindoe, SEPARATED),
    _source_reader("source spindoe, index.csv", "spindoe", _write_index, SEPARATED),
    _source_reader("source tt3d", "tt3d", made_up.write_tt3d, SEPARATED),
    _source_reader(
        "source isr_ball_prediction",
        "isr_ball_prediction",
        made_up.write_isr,
        [*hostile.NOTHING_GOOD, *hostile.HDF5],
    ),
    _source_reader(
        "source competitive_robot_table_tennis",
        "competitive_robot_table_tennis",
        made_up.write_competitive,
        JSON,
    ),
    Reader("params.yaml", _copied("params.yaml"), _read_params, YAML),
    Reader(
        "profile", _copied("params.yaml", "experiments/profiles/smoke.yaml"), _read_profile, YAML
    ),
    Reader("sweep", _copied("params.yaml", SWEEP), _read_sweep, YAML),
    Reader("best_params.yaml", _write_best, _read_best, YAML),
    Reader("simulator", _write_simulator, _read_simulator, YAML),
    Reader("predictor, weights", _write_predictor("weights.safetensors"), _read_predictor, WEIGHTS),
    Reader(
        "predictor, predictor.json",
        _write_predictor("predictor.json"),
        _read_predictor,
        [*JSON, _huge_network()],
    ),
    Reader("policy, weights", _write_policy("weights.safetensors"), _read_policy, WEIGHTS),
    Reader("policy, policy.json", _write_policy("policy.json"), _read_policy, JSON),
    Reader("verdict.json", _write_verdict, _read_verdict, JSON),
    Reader("exam records", _write_records, _read_records, JSON),
    Reader("benchmark forecasts", _write_forecasts, _read_forecasts, PARQUET),
    Reader("manifest.json", _write_manifest, _read_manifest, JSON),
    Reader("truth.json", _write_truth, _read_truth, JSON),
    Reader("shots.json", _write_shots, _read_shots, JSON),
    Reader("report, tables", _write_columns, _read_columns, SEPARATED),
    Reader("forecast_error.csv", _copied(str(FORECAST_ERRORS)), _read_errors, SEPARATED),
    Reader(
        "profile's run, params.json", _copied("reports/paper/params.json"), _read_kept_run, JSON
    ),
    Reader("timings", _write_timings, _read_timings, JSON),
    *[
        Reader(name, _write_table("segment", name), _read_segmented, PARQUET)
        for name in ("episodes.parquet", "contacts.parquet", "samples.parquet")
    ],
    Reader(
        "true_contacts.parquet",
        _write_table("ingest", "true_contacts.parquet"),
        _read_true_contacts,
        PARQUET,
    ),
]
