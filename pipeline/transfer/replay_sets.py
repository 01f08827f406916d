"""The sets of shots that are replayed to policies, and why other shots are excluded."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rallygap.models.ball.contact_laws import TABLE
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.simulators import shipped
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.policy.incoming_balls import FLOOR, MAX_DURATION, PATH_TIMES, REACH_LIMIT
from rallygap.models.policy.outcome import with_net
from rallygap.models.policy.settings import SensorNoise
from rallygap.models.replay.paths import measured_path, true_path
from rallygap.models.replay.replayed_balls import fly_on, measured_in_time, reachable
from rallygap.models.replay.shots import (
    HALF_TURN,
    NO_MEASUREMENTS,
    Shot,
    extend_measurements,
    flies_away,
    from_launch,
    half_turn,
)
from rallygap.models.segmentation.split import NOT_REPLAYED, REPLAY_SETS
from rallygap.pipeline.evaluation.predictors import ARENA
from rallygap.pipeline.io.episodes import MeasuredEpisode, read_episodes
from rallygap.pipeline.io.ground_truth import read_contacts, read_truth
from rallygap.pipeline.io.schemas import EPISODES, LAUNCHES, STATE_COLUMNS, read_checked
from rallygap.pipeline.io.source_manifest import Manifest, read_manifest
from rallygap.pipeline.params import Sim2RealSettings
from rallygap.pipeline.runtime.console import warn
from rallygap.pipeline.runtime.errors import InputError

LITERATURE = shipped("literature")

ARENA_SETS = tuple(REPLAY_SETS)  # in the order of reports

# Why a shot is excluded.
TOO_FEW_SAMPLES = "too few samples in the first 55 ms"
FROM_NEAR = "not from the far half"
NO_BOUNCE = "no bounce on the robot's half"


@dataclass(frozen=True)
class ReplaySet:
    """The B shots of a set that are replayed.

    Attributes:
        name: of the set.
        shots: B.
        recordings: (B,) ids of the recordings that they are from.
        path: (B, N, 9) as in ``IncomingBalls``.
        playable: (B, 2) as in ``IncomingBalls``.
        simulator: flies balls on from the ends of their known paths, and from the racket.
        oracle: the physics that flew the balls; ``None`` for real balls.
        spin: how spins were measured, from the manifest.
        rotated: number of shots rotated by half a turn to fly to the robot.
        in_reach: number of shots that pass through the racket's workspace.
        excluded: numbers of other shots, by the reason.
    """

    name: str
    shots: Sequence[Shot]
    recordings: Sequence[str]
    path: Floats
    playable: Floats
    simulator: Simulator
    oracle: Simulator | None
    spin: str
    rotated: int
    in_reach: int
    excluded: Counter[str]

    def __len__(self) -> int:
        return len(self.shots)


@dataclass(frozen=True)
class _Candidates:
    """The shots of a set before exclusion; ``rotated`` (B,) marks the rotated ones."""

    name: str
    source: str
    shots: list[Shot]
    recordings: list[str]
    rotated: Bools
    simulator: Simulator
    oracle: Simulator | None


def read_replay_sets(artifacts: Path, settings: Sim2RealSettings, seed: int) -> list[ReplaySet]:
    """Return all sets with shots that can be replayed; warn of sets without.

    These are the arena's replay sets; the shots of other sources that no predictor was trained on;
    and launches, flown by the literature's simulator.

    Args:
        artifacts: the folder of all stages' artefacts.
        settings: number of launches and measurement noise.
        seed: of the choice of launches and of the noise.

    Raises:
        InputError: an artefact is missing or broken, or there is no shot to replay.
    """
    manifest = read_manifest(artifacts / "ingest" / "manifest.json")
    launches = artifacts / "ingest" / "launches.parquet"
    candidates = [*_measured(artifacts, manifest), *_launched(launches, settings, seed)]
    sets = [
        _replay_set(
            candidate,
            manifest.sources[candidate.source].spin,
            settings.noise,
            np.random.default_rng([seed, *candidate.name.encode()]),
        )
        for candidate in candidates
    ]
    for replayed in sets:
        if not len(replayed):
            reasons = ", ".join(f"{count} {why}" for why, count in replayed.excluded.items())
            warn(f"no shot of {replayed.name} can be replayed: {reasons}")
    if not any(map(len, sets)):
        problem = "no shot can be replayed; ingest more, or let segment.split.replay keep more"
        raise InputError(artifacts / "segment" / "episodes.parquet", problem)
    return [replayed for replayed in sets if len(replayed)]


def _measured(artifacts: Path, manifest: Manifest) -> Iterator[_Candidates]:
    truth = read_truth(artifacts / "ingest" / "truth.json")
    contacts = artifacts / "ingest" / "true_contacts.parquet"
    for name, members in _episodes(artifacts / "segment", manifest.labelled_once).items():
        source, recordings = members[0].source, [member.recording_id for member in members]
        if source == ARENA and truth is not None:
            known = read_contacts(contacts, np.array(recordings))
            shots = [
                Shot(
                    from_launch(member.episode),
                    *true_path(truth, known[member.recording_id], float(member.episode.times[0])),
                )
                for member in members
            ]
            rotated = np.zeros(len(members), bool)
            simulator = truth.simulator
            if "racket_bounce" not in simulator.effects:
                racket = LITERATURE.effects["racket_bounce"]
                simulator = simulator.amended("racket_bounce", **racket)
            yield _Candidates(name, source, shots, recordings, rotated, simulator, truth.simulator)
        else:
            measured = [from_launch(member.episode) for member in members]
            away = np.array([flies_away(episode) for episode in measured])
            pairs = zip(measured, away, strict=True)
            facing = [half_turn(episode) if turned else episode for episode, turned in pairs]
            shots = [Shot(episode, *measured_path(episode)) for episode in facing]
            yield _Candidates(name, source, shots, recordings, away, LITERATURE, None)


def _episodes(folder: Path, labelled_once: set[str]) -> dict[str, list[MeasuredEpisode]]:
    """Return the unbroken episodes that no predictor was trained on, by set."""
    episodes = read_episodes(folder, labelled_once, splits=("test", "replay"))
    table = read_checked(folder / "episodes.parquet", EPISODES)
    replay_set = dict(zip(table["episode_id"], table["replay_set"], strict=True))
    sets: dict[str, list[MeasuredEpisode]] = {name: [] for name in ARENA_SETS}
    for episode in episodes:
        name = replay_set[episode.episode_id] if episode.source == ARENA else episode.source
        if episode.unbroken and name != NOT_REPLAYED:
            sets.setdefault(name, []).append(episode)
    return {name: members for name, members in sets.items() if members}


def _launched(path: Path, settings: Sim2RealSettings, seed: int) -> Iterator[_Candidates]:
    table = read_checked(path, LAUNCHES)
    for source, rows in table.groupby(table["launch_id"].str.split("/").str[0]):
        random = np.random.default_rng([seed, *str(source).encode()])
        drawn = random.permutation(len(rows))[: settings.launches]
        launches = rows[STATE_COLUMNS].to_numpy()[drawn]
        ids = [str(launch_id) for launch_id in rows["launch_id"].to_numpy()[drawn]]
        away = launches[:, 4] > 0
        launches[away] *= np.tile(HALF_TURN, 3)
        shots = _launched_shots(launches, settings.noise, random)
        yield _Candidates(str(source), str(source), shots, ids, away, LITERATURE, LITERATURE)


def _launched_shots(
    launches: Floats, noise: SensorNoise, random: np.random.Generator
) -> list[Shot]:
    """Return measured shots flown by the literature's simulator from (B, 9) states."""
    flight = with_net(LITERATURE).fly(launches, PATH_TIMES)
    lost = (flight.states[..., 1] < REACH_LIMIT) | (flight.states[..., 2] < FLOOR)
    until = np.where(lost.any(axis=1), PATH_TIMES[lost.argmax(axis=1)], MAX_DURATION)
    met = flight.contacts
    shots = [
        Shot(NO_MEASUREMENTS, path, times[surfaces == TABLE])
        for path, times, surfaces in zip(flight.states, met.time, met.surface, strict=True)
    ]
    return extend_measurements(shots, flight.states, until, noise, random)


def _replay_set(
    candidates: _Candidates, spin: str, noise: SensorNoise, random: np.random.Generator
) -> ReplaySet:
    reasons = [_reason(shot) for shot in candidates.shots]
    rows = [row for row, reason in enumerate(reasons) if not reason]
    path, playable = fly_on(candidates.simulator, [candidates.shots[row] for row in rows])
    lands = np.isfinite(playable[:, 0])
    kept = np.array(rows, dtype=np.int64)[lands]
    path, playable = path[lands], playable[lands]
    shots = [candidates.shots[row] for row in kept]
    excluded = Counter(reason for reason in reasons if reason)
    excluded[NO_BOUNCE] = int((~lands).sum())
    return ReplaySet(
        candidates.name,
        extend_measurements(shots, path, playable[:, 1], noise, random),
        [candidates.recordings[row] for row in kept],
        path,
        playable,
        candidates.simulator,
        candidates.oracle,
        spin,
        int(candidates.rotated[kept].sum()),
        int(reachable(path, playable).sum()),
        +excluded,
    )


def _reason(shot: Shot) -> str:
    """Return why a shot is excluded before its flight to the robot is known, or an empty string."""
    if not len(shot.known) or not measured_in_time(shot.measured):
        return TOO_FEW_SAMPLES
    return "" if shot.known[0, 1] > 0 else FROM_NEAR
