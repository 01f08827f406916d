"""Shots whose physics is known, as ingest, segment and train_predictor would leave them."""

from pathlib import Path

import numpy as np
import pandas as pd

from rallygap.models.arena.bounce_scatter import BounceScatter
from rallygap.models.arena.cameras import CameraField, SlowError
from rallygap.models.arena.truth import Truth
from rallygap.models.ball.simulators import shipped
from rallygap.models.predictors.spread import Spread
from rallygap.pipeline.io.artifacts import write_json, write_table
from rallygap.pipeline.io.ground_truth import STATE_COLUMNS
from rallygap.pipeline.io.schemas import CONTACTS, EPISODES, SAMPLES, TRUE_CONTACTS, checked
from rallygap.pipeline.params import PhysicsPredictorSettings, load_params
from rallygap.pipeline.predictors.storage import Learning, TrainedPredictor, save_predictor
from tests.models.predictors.small_training import BRIEF, TINY, network

TIMES = 0.005 * np.arange(101)
SIMULATOR = shipped("literature")
NOISE = 0.003  # m
PREDICTORS = {
    "physics_true": PhysicsPredictorSettings(kind="physics", simulator="literature"),
    "physics_c": PhysicsPredictorSettings(kind="physics", simulator="imperfect_c"),
}
SPIN = {"arena": "per_sample", "labelled": "per_recording", "plain": "none"}
SHOTS = [
    *[("arena/cannon", number) for number in range(2)],
    *[("arena/pro", number) for number in range(2, 4)],
    *[("labelled", number) for number in range(3)],
    *[("plain", number) for number in range(3)],
]


def params(**groups):
    """The repository's parameters with the predictors of these tests, and ``groups`` changed."""
    repository = load_params(Path(__file__).parents[2] / "params.yaml")
    changes = {"predictors": PREDICTORS, "bootstrap_resamples": 50}
    evaluation = repository.evaluate_predictor.model_copy(update=changes)
    return repository.model_copy(update={"evaluate_predictor": evaluation, **groups})


def write_inputs(root, shots=(), sources=tuple(SPIN)):
    """Write the artefacts of all shots of some sources, and of ``shots``."""
    chosen = [shot for shot in SHOTS if shot[0].split("/")[0] in sources]
    parts = [shot_tables(place, number) for place, number in chosen] + list(shots)
    samples, contacts, episodes, true = zip(*parts, strict=True)
    segmented, ingested = (root / "artifacts" / name for name in ("segment", "ingest"))
    for folder, parts, contract in (
        (segmented, samples, SAMPLES),
        (segmented, contacts, CONTACTS),
        (segmented, episodes, EPISODES),
        (ingested, true, TRUE_CONTACTS),
    ):
        table = checked(pd.concat(parts, ignore_index=True), contract)
        write_table(folder / f"{contract.name}.parquet", table)
    field = CameraField(standard_deviation=0.0, length=1.0, seed=0)
    truth = Truth(SIMULATOR, BounceScatter(0.0, 0.0), SlowError(0.0, 0.1), field, 0.0)
    write_json(ingested / "truth.json", truth.to_dict() if "arena" in sources else None)
    manifest = {name: source_record(name, spin) for name, spin in SPIN.items() if name in sources}
    write_json(ingested / "manifest.json", {"sources": manifest})
    write_trained(root, "tiny")


def write_trained(root, name, seed=0, made=None, **changes):
    """Save an untrained network as if it had been trained; return where it is."""
    made = made or network(TINY, seed)
    counts = {"episodes": 1, "windows": 1, "validation_episodes": 1}
    described = TrainedPredictor(
        name=name,
        network=TINY,
        parameters=made.parameter_count,
        sources=["arena"],
        starts_from=None,
        learning=Learning(**counts, settings=BRIEF, seed=0),
    )
    folder = root / "artifacts" / "train_predictor" / name
    save_predictor(folder, made, Spread(), described.model_copy(update=changes))
    return folder


def shot_tables(place, number, **changes):
    """Samples, contact, episode and true contacts of one shot of a cannon."""
    source, recording = place.split("/")[0], f"{place}/{number}"
    name = f"{recording}/00"
    ball = [0.1 * number, 1.3, 0.3, 0.2, -8.0, 0.5, -150.0 + 20 * number, 10.0, 5.0]
    flight = SIMULATOR.fly(ball, TIMES)
    bounce = flight.contacts.time[0, 0]
    measured = flight.states[0].copy()
    if source == "arena":
        measured[:, :3] += np.random.default_rng(number).normal(0, NOISE, (len(TIMES), 3))
    if SPIN[source] == "none":
        measured[:, 6:] = np.nan
    ids = {"recording_id": recording, "episode_id": name}
    samples = pd.DataFrame(measured, columns=STATE_COLUMNS)
    samples = samples.assign(**ids, arc=(bounce < TIMES).astype(int), t=TIMES, outlier=False)
    contact = {**ids, "kind": "table", "t": bounce, "px": 0.0, "py": 0.0, "pz": 0.02}
    contacts = pd.DataFrame([{**contact, "speed_change": 4.0}])
    true = pd.DataFrame([ball, flight.contacts.after[0, 0]], columns=STATE_COLUMNS)
    true = true.assign(recording_id=recording, t=[0.0, bounce], kind=["launch", "table"])
    episodes = pd.DataFrame([_episode(recording, name) | changes])
    return samples[list(SAMPLES.columns)], contacts, episodes, true[list(TRUE_CONTACTS.columns)]


def source_record(name, spin):
    """What the manifest says of a source."""
    described = {"name": name, "kind": "cannon", "spin": spin, "licence": "made up", "note": ""}
    counts = {"rate_hz": 200.0, "recordings": 3, "launches": 0, "rows_read": 303, "rows_kept": 303}
    return {**described, **counts, "rows_refused": {}, "labels_refused": {}, "files": []}


def _episode(recording, name):
    place = {"episode_id": name, "recording_id": recording, "source": recording.split("/")[0]}
    ends = {"start": 0.0, "end": TIMES[-1], "starts_with": "launch", "ends_with": "recording"}
    counts = {"samples": len(TIMES), "outliers": 0, "bounces": 1, "residual": 0.003}
    return {**place, **ends, **counts, "unbroken": True, "split": "test", "replay_set": "none"}
