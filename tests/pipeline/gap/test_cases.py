"""Cases of the gap workflow: which episodes are shots, which shots, which simulators."""

import numpy as np
import pytest

from rallygap.models.gap.fit.shots import held_out
from rallygap.models.gap.settings import DEFAULTS
from rallygap.models.predictors.windows import Episode
from rallygap.pipeline.gap.cases import cases, drawn, nominal_simulator
from rallygap.pipeline.gap.shots import net_contacts, source_shots
from rallygap.pipeline.io.episodes import MeasuredEpisode
from rallygap.pipeline.params import CloseGapSettings, ComparedSimulatorSettings
from rallygap.pipeline.runtime.errors import InputError


def episode(name="lab/0/00", samples=20, touched=(), nets=(), bounces=(), unbroken=True):
    """An episode at 100 Hz whose ball bounces, and touches other things at some times."""
    times, places = 0.01 * np.arange(samples), np.zeros((samples, 3))
    arcs = np.zeros(samples, dtype=int)
    whole = Episode(times, places, places, places, times < 0, arcs, np.array(bounces))
    contacts = np.array([*touched, *nets]), np.array(nets)
    recording = name.rpartition("/")[0]
    return MeasuredEpisode(name, recording, "lab", "train", unbroken, whole, *contacts)


def episodes(recordings=12, each=1):
    return [
        episode(f"lab/{recording:02d}/{number}")
        for recording in range(recordings)
        for number in range(each)
    ]


def simulator(name="imperfect_c", without=()):
    return ComparedSimulatorSettings(simulator=name, without=list(without))


@pytest.mark.parametrize(
    ("one", "left_out"),
    [
        (episode(), {}),
        (episode(touched=[0.155], bounces=[0.095]), {}),
        (episode(nets=[0.095]), {"too short": 1}),
        (episode(samples=12), {"too short": 1}),
        (episode(unbroken=False), {"broken": 1}),
    ],
)
def test_a_shot_is_whole_and_long_enough(one, left_out):
    found = source_shots([one])
    assert (len(found.members), found.left_out) == (not left_out, left_out)


def test_a_shot_ends_where_the_ball_touches_something_else_than_the_table():
    touching = episode(bounces=[0.055], touched=[0.185], nets=[0.155])
    touched, bounced = source_shots([touching, episode(bounces=[0.055])]).members
    assert touched.episode.times[-1] == pytest.approx(0.15)
    assert len(bounced.episode.times) == 20


def test_arcs_about_the_net_end_at_the_contacts_next_to_it():
    found = net_contacts([episode(samples=40, bounces=[0.055, 0.305], nets=[0.155])])
    assert len(found) == 1
    assert found.before.times[0] == pytest.approx(np.arange(0.06, 0.155, 0.01))
    assert found.after.times[0] == pytest.approx(np.arange(0.16, 0.305, 0.01))


def test_contacts_with_short_arcs_or_other_things_do_not_serve():
    others = [
        episode(samples=40),
        episode(samples=40, touched=[0.155]),
        episode(samples=40, nets=[0.155], unbroken=False),
        episode(samples=40, bounces=[0.125], nets=[0.155]),
        episode(samples=18, nets=[0.155]),
    ]
    assert len(net_contacts(others)) == 0


def test_a_split_has_the_same_shots_for_all_simulators_and_others_than_the_next():
    known = {"c": simulator(), "bare": simulator(without=["magnus"])}
    settings = CloseGapSettings(simulators=known, splits=2, shots=8, level=0.01)
    sources = {"lab": source_shots(episodes()), "other": source_shots(episodes(4))}
    found = list(cases(sources, settings, seed=0))
    simulators = [f"{name}-{k}" for name in known for k in (0, 1)]
    names = [f"{source}-{each}" for source in ("lab", "other") for each in simulators]
    assert [one.name for one in found] == names
    assert [len(one.shots) for one in found] == [8] * 4 + [4] * 4
    assert {one.level for one in found} == {0.01}
    kept = [set(one.shots.names[held_out(one.shots, DEFAULTS)]) for one in found[:3]]
    assert kept[0] == kept[2] != kept[1]


def test_shots_of_a_recording_stay_together():
    shots = drawn(episodes(recordings=6, each=3), 18, np.random.default_rng(0))
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
