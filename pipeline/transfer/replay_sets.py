"""The shots of every set that are replayed to policies, and why others are not."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from models.arena.truth import Truth
from models.ball.contact_laws import TABLE
from models.ball.simulator import Simulator
from models.ball.simulators import shipped
from models.policy.incoming_balls import BEHIND, FLOOR, LONGEST, PATH_TIMES
from models.policy.outcome import with_net
from models.policy.settings import SensorNoise
from models.replay.measured_path import measured_path
from models.replay.replayed_balls import fly_on, seen_in_time, within_reach
from models.replay.shots import (
    HALF_TURN,
    NOTHING_MEASURED,
    Shot,
    flies_away,
    from_launch,
    half_turned,
    measure_on,
)
from models.replay.true_path import true_path
from models.segmentation.split import NOT_REPLAYED, STROKE_GROUPS
from pipeline.evaluation.predictors import ARENA
from pipeline.io.episodes import MeasuredEpisode, read_episodes
from pipeline.io.ground_truth import read_contacts, read_truth
from pipeline.io.schemas import EPISODES, LAUNCHES, STATE_COLUMNS, read_checked
from pipeline.params import Sim2RealSettings
from pipeline.runtime.console import warn
from pipeline.runtime.errors import InputError
from pipeline.sources.manifest import Manifest, read_manifest

Floats = NDArray[np.float64]

LITERATURE = shipped("literature")

ARENA_SETS = (*STROKE_GROUPS, "receive")  # in the order of reports

# Why a shot is not replayed.
UNSEEN = "seen too little within its first 55 ms"
FROM_NEAR = "not from the far half"
NO_BOUNCE = "no bounce on the robot's half"


@dataclass(frozen=True)
class ReplaySet:
    """The B shots of a set that are replayed.

    Attributes:
        name: of the set.
        shots: B.
        path: (B, N, 9) as in ``Incoming``.
        playable: (B, 2) as in ``Incoming``.
        simulator: flies balls on from where they are known last, and from the racket.
        oracle: the physics that flew the balls; ``None`` where nobody knows it.
        spin: how spins were measured, as the manifest says it.
        turned: how many shots had to be turned to fly to the robot.
        in_reach: how many come to where the racket strikes well, fast or slow.
        left_out: how many others there are, by the reason why they are not replayed.
    """

    name: str
    shots: Sequence[Shot]
    path: Floats
    playable: Floats
    simulator: Simulator
    oracle: Simulator | None
    spin: str
    turned: int
    in_reach: int
    left_out: Counter[str]

    def __len__(self) -> int:
        return len(self.shots)


@dataclass(frozen=True)
class _Found:
    """The shots of a set, before those are left out that cannot be replayed."""

    name: str
    source: str
    shots: list[Shot]
    turned: NDArray[np.bool_]
    simulator: Simulator
    oracle: Simulator | None


def read_replay_sets(artifacts: Path, settings: Sim2RealSettings, seed: int) -> list[ReplaySet]:
    """Return every set with a shot that can be replayed; warn of those without.

    These are the arena's replay sets; of every measured source the shots that no predictor has
    learned from; and launches, which the literature's simulator flies.

    Args:
        artifacts: the folder of all stages' artefacts.
        settings: how many launches, and how they are measured.
        seed: of the launches that are drawn, and of their noise.

    Raises:
        InputError: an artefact is missing or broken, or there is no shot to replay.
    """
    manifest = read_manifest(artifacts / "ingest" / "manifest.json")
    launches = artifacts / "ingest" / "launches.parquet"
    found = [*_measured(artifacts, manifest), *_launched(launches, settings, seed)]
    sets = [
        _replay_set(
            one,
            manifest.sources[one.source].spin,
            settings.noise,
            np.random.default_rng([seed, *one.name.encode()]),
        )
        for one in found
    ]
    for one in sets:
        if not len(one):
            reasons = ", ".join(f"{count} {why}" for why, count in one.left_out.items())
            warn(f"no shot of {one.name} can be replayed: {reasons}")
    if not any(map(len, sets)):
        problem = "no shot can be replayed; ingest more, or let segment.split.replay keep more"
        raise InputError(artifacts / "segment" / "episodes.parquet", problem)
    return [one for one in sets if len(one)]


def _measured(artifacts: Path, manifest: Manifest) -> Iterator[_Found]:
    truth = read_truth(artifacts / "ingest" / "truth.json")
    contacts = artifacts / "ingest" / "true_contacts.parquet"
    for name, members in _episodes(artifacts / "segment", manifest.labelled_once).items():
        source = members[0].source
        if source == ARENA and truth is not None:
            shots, turned = _arena_shots(members, truth, contacts), np.zeros(len(members), bool)
            simulator = _with_racket(truth.simulator)
            yield _Found(name, source, shots, turned, simulator, truth.simulator)
        else:
            measured = [from_launch(one.episode) for one in members]
            turned = np.array([flies_away(one) for one in measured])
            facing = [half_turned(one) if flies_away(one) else one for one in measured]
            shots = [Shot(one, *measured_path(one)) for one in facing]
            yield _Found(name, source, shots, turned, LITERATURE, None)


def _episodes(folder: Path, labelled_once: set[str]) -> dict[str, list[MeasuredEpisode]]:
    """Return the unbroken episodes that no predictor has learned from, by set."""
    episodes = read_episodes(folder, labelled_once, splits=("test", "replay"))
    table = read_checked(folder / "episodes.parquet", EPISODES)
    replay_set = dict(zip(table["episode_id"], table["replay_set"], strict=True))
    sets: dict[str, list[MeasuredEpisode]] = {name: [] for name in ARENA_SETS}
    for one in episodes:
        name = replay_set[one.episode_id] if one.source == ARENA else one.source
        if one.unbroken and name != NOT_REPLAYED:
            sets.setdefault(name, []).append(one)
    return {name: members for name, members in sets.items() if members}


def _arena_shots(members: list[MeasuredEpisode], truth: Truth, path: Path) -> list[Shot]:
    contacts = read_contacts(path, np.array([one.recording_id for one in members]))
    starts = [float(one.episode.times[0]) for one in members]
    return [
        Shot(from_launch(one.episode), *true_path(truth, contacts[one.recording_id], start))
        for one, start in zip(members, starts, strict=True)
    ]


def _launched(path: Path, settings: Sim2RealSettings, seed: int) -> Iterator[_Found]:
    table = read_checked(path, LAUNCHES)
    for source, rows in table.groupby(table["launch_id"].str.split("/").str[0]):
        random = np.random.default_rng([seed, *str(source).encode()])
        drawn = random.permutation(len(rows))[: settings.launches]
        launches = rows[STATE_COLUMNS].to_numpy()[drawn]
        turned = launches[:, 4] > 0
        launches[turned] *= np.tile(HALF_TURN, 3)
        shots = _launched_shots(launches, settings.noise, random)
        yield _Found(str(source), str(source), shots, turned, LITERATURE, LITERATURE)


def _launched_shots(
    launches: Floats, noise: SensorNoise, random: np.random.Generator
) -> list[Shot]:
    """Return shots that fly from (B, 9) states as the literature says, and are measured."""
    flight = with_net(LITERATURE).fly(launches, PATH_TIMES)
    lost = (flight.states[..., 1] < BEHIND) | (flight.states[..., 2] < FLOOR)
    until = np.where(lost.any(axis=1), PATH_TIMES[lost.argmax(axis=1)], LONGEST)
    met = flight.contacts
    shots = [
        Shot(NOTHING_MEASURED, path, times[surfaces == TABLE])
        for path, times, surfaces in zip(flight.states, met.time, met.surface, strict=True)
    ]
    return measure_on(shots, flight.states, until, noise, random)


def _with_racket(simulator: Simulator) -> Simulator:
    """Return the simulator with a racket: the literature's where it has none."""
    there = "racket_bounce" in simulator.effects
    racket = LITERATURE.effects["racket_bounce"]
    return simulator if there else simulator.amended("racket_bounce", **racket)


def _replay_set(
    found: _Found, spin: str, noise: SensorNoise, random: np.random.Generator
) -> ReplaySet:
    reasons = [_reason(shot) for shot in found.shots]
    rows = [row for row, reason in enumerate(reasons) if not reason]
    path, playable = fly_on(found.simulator, [found.shots[row] for row in rows])
    lands = np.isfinite(playable[:, 0])
    kept = np.array(rows, dtype=np.int64)[lands]
    path, playable = path[lands], playable[lands]
    shots = [found.shots[row] for row in kept]
    left_out = Counter(reason for reason in reasons if reason)
    left_out[NO_BOUNCE] = int((~lands).sum())
    return ReplaySet(
        found.name,
        measure_on(shots, path, playable[:, 1], noise, random),
        path,
        playable,
        found.simulator,
        found.oracle,
        spin,
        int(found.turned[kept].sum()),
        int(within_reach(path, playable).sum()),
        +left_out,
    )


def _reason(shot: Shot) -> str:
    """Return why a shot cannot be replayed, as far as its flight to the robot does not matter."""
    if not len(shot.known) or not seen_in_time(shot.measured):
        return UNSEEN
    return "" if shot.known[0, 1] > 0 else FROM_NEAR
