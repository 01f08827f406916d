"""Cases of the gap workflow: which shots, which simulators."""

import numpy as np
import pytest

from rallygap.models.gap.fit.shots import held_out
from rallygap.models.gap.settings import DEFAULTS
from rallygap.models.predictors.windows import Episode
from rallygap.pipeline.gap.cases import cases, drawn, nominal_simulator
from rallygap.pipeline.gap.shots import source_shots
from rallygap.pipeline.io.episodes import MeasuredEpisode
from rallygap.pipeline.params import CloseGapSettings, ComparedSimulatorSettings
from rallygap.pipeline.runtime.errors import InputError

TIMES, NONE = 0.01 * np.arange(20), np.empty(0)


def simulator(name="imperfect_c", without=()):
    return ComparedSimulatorSettings(simulator=name, without=list(without))


def episodes(recordings=12, each=1):
    """Episodes that no two are alike, none of which touches the net."""
    for number in range(recordings * each):
        places = np.full((20, 3), float(number))
        whole = Episode(TIMES, places, places, places, TIMES < 0, 0 * TIMES, NONE)
        recording = f"lab/{number // each:02d}"
        name = f"{recording}/{number % each}"
        yield MeasuredEpisode(name, recording, "lab", "train", True, whole, NONE, NONE)


def shots(recordings=12):
    return source_shots(list(episodes(recordings)))


def test_a_split_has_the_same_shots_for_all_simulators_and_others_than_the_next():
    known = {"c": simulator(), "bare": simulator(without=["magnus"])}
    settings = CloseGapSettings(simulators=known, splits=2, shots=8, level=0.01)
    found = list(cases({"lab": shots(), "other": shots(4)}, settings, seed=0))
    simulators = [f"{name}-{k}" for name in known for k in (0, 1)]
    names = [f"{source}-{each}" for source in ("lab", "other") for each in simulators]
    assert [one.name for one in found] == names
    assert [len(one.shots) for one in found] == [8] * 4 + [4] * 4
    assert {one.level for one in found} == {0.01}
    kept = [set(one.shots.names[held_out(one.shots, DEFAULTS)]) for one in found[:3]]
    assert kept[0] == kept[2] != kept[1]


def test_shots_of_a_recording_stay_together():
    shots = drawn(list(episodes(recordings=6, each=3)), 18, np.random.default_rng(0))
    recordings = np.array([name.rsplit("/", 1)[0] for name in shots.names])
    assert len(set(zip(recordings, shots.groups, strict=True))) == 6
    held = held_out(shots, DEFAULTS)
    assert not set(recordings[held]) & set(recordings[~held])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (simulator("imperfect_d"), "imperfect_d.*did you mean imperfect_"),
        (simulator(without=["wind"]), "mine: has no effect wind to remove; it has gravity"),
        (simulator(without=["table_bounce"]), r"close_gap\.simulators\.mine: needs table_bounce"),
    ],
)
def test_a_simulator_that_cannot_be_used_is_refused(settings, message):
    with pytest.raises(InputError, match=message):
        nominal_simulator(settings, "mine")
