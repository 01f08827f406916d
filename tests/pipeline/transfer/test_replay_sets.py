"""Which shots are replayed, how they come to the robot, and why others do not."""

import numpy as np
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.models.policy.incoming_balls import PATH_TIMES
from rallygap.pipeline.io.artifacts import read_json, write_json
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.transfer.replay_sets import (
    FROM_NEAR,
    NO_BOUNCE,
    TOO_FEW_SAMPLES,
    read_replay_sets,
)
from tests.pipeline.measured_shots import SIMULATOR, TIMES, shot_tables
from tests.pipeline.replayed import (
    LAUNCH,
    SETTINGS,
    SOURCE,
    launched,
    moved,
    replayed,
    rotated,
    write_replays,
)
from tests.stages.small_runs import run_ingest, run_segment


def read(artifacts, seed=0, **changes):
    settings = SETTINGS.model_copy(update=changes)
    return {one.name: one for one in read_replay_sets(artifacts, settings, seed)}


def flown(number):
    """The ball of a made-up shot as it flies."""
    ball = [0.1 * number, 1.3, 0.3, 0.2, -8.0, 0.5, -150.0 + 20 * number, 10.0, 5.0]
    return SIMULATOR.fly(ball, PATH_TIMES)


@pytest.fixture(scope="module")
def sets(tmp_path_factory):
    """Sets of all kinds; not to be changed."""
    shots = [
        replayed("arena/club", 4, replay_set="receive"),
        replayed("arena/pro", 5),
        replayed("arena/pro", 6),
    ]
    launches = launched(*np.tile(LAUNCH, (4, 1)))
    return read(write_replays(tmp_path_factory.mktemp("sets"), shots, launches=launches))


def test_the_arena_s_replay_sets_come_first_then_test_shots_then_launches(sets):
    counts = [(name, len(one)) for name, one in sets.items()]
    assert counts == [
        ("stroke_pro", 2), ("receive", 1), ("labelled", 3), ("plain", 3), (SOURCE, 4)
    ]  # fmt: skip
    assert [one.spin for one in sets.values()][1:4] == ["per_sample", "per_recording", "none"]
    known = {name: one.oracle for name, one in sets.items() if one.oracle is not None}
    assert list(known) == ["stroke_pro", "receive", SOURCE]
    assert all(one.simulator == shipped("literature") for one in sets.values())


def test_a_replayed_shot_is_where_it_truly_was_and_a_measured_one_where_it_was_measured(sets):
    for row, number in enumerate((5, 6)):
        flight = flown(number)
        np.testing.assert_allclose(sets["stroke_pro"].path[row], flight.states[0], atol=1e-5)
        bounce = sets["stroke_pro"].playable[row, 0]
        assert bounce == pytest.approx(flight.contacts.time[0, 0])
    count = round(TIMES[-1] / 0.001)
    for row, path in enumerate(sets["labelled"].path):
        off = path[:count] - flown(row).states[0, :count]
        assert np.linalg.norm(off[:, :3], axis=1).max() < 0.004
        assert np.linalg.norm(off[:, 6:], axis=1).max() < 10.0  # its label ends at the bounce


def test_a_shot_that_flies_the_other_way_is_turned_and_is_the_same_then(tmp_path, sets):
    shots = [rotated(shot_tables("plain", number)) for number in range(3)]
    one = read(write_replays(tmp_path, shots, sources=()))["plain"]
    assert (sets["plain"].rotated, one.rotated) == (0, 3)
    np.testing.assert_allclose(one.path, sets["plain"].path, atol=1e-9)


def test_shots_that_cannot_be_replayed_are_counted_with_the_reason(tmp_path):
    near = moved(shot_tables("plain", 3), ["py"], lambda column: column - 2.0)
    samples, *others = moved(shot_tables("plain", 4), ["px"], lambda column: column + 1.0)
    wide = samples[samples["t"] < 0.25], *others
    unseen = moved(shot_tables("plain", 5), ["outlier"], lambda column: ~column)
    broken = shot_tables("plain", 6, unbroken=False)
    learned_from = shot_tables("plain", 7, split="train")
    shots = [near, wide, unseen, broken, learned_from]
    one = read(write_replays(tmp_path, shots, sources=("plain",)))["plain"]
    assert len(one) == 3
    assert one.excluded == {FROM_NEAR: 1, TOO_FEW_SAMPLES: 1, NO_BOUNCE: 1}


def test_launches_fly_to_the_robot_as_the_literature_says(tmp_path):
    away = LAUNCH * np.tile([-1.0, -1.0, 1.0], 3)
    too_long = LAUNCH * np.array([1, 1, 1, 1, 2.5, 1, 1, 1, 1])
    launches = launched(LAUNCH, away, too_long)
    one = read(write_replays(tmp_path, launches=launches, sources=("plain",)))[SOURCE]
    path = SIMULATOR.fly(LAUNCH, PATH_TIMES).states
    np.testing.assert_allclose(one.path, np.tile(path, (2, 1, 1)), atol=1e-9)
    assert one.rotated == 1 and one.excluded == {NO_BOUNCE: 1}


def test_as_many_launches_are_drawn_as_asked_for(tmp_path):
    states = np.tile(LAUNCH, (50, 1)) + 0.1 * np.arange(50)[:, None] / 50
    artifacts = write_replays(tmp_path, launches=launched(*states), sources=("plain",))
    one, again, other = (read(artifacts, seed, launches=20)[SOURCE] for seed in (0, 0, 1))
    assert len(one) == 20
    np.testing.assert_array_equal(one.path, again.path)
    assert not np.array_equal(one.path, other.path)
    for first, second in zip(one.shots, again.shots, strict=True):
        np.testing.assert_array_equal(first.measured.positions, second.measured.positions)


def test_an_environment_without_a_racket_gets_the_literature_s(tmp_path):
    artifacts = write_replays(tmp_path, [replayed("arena/pro", 5)], sources=("arena",))
    path = artifacts / "ingest" / "truth.json"
    truth = read_json(path)
    del truth["simulator"]["racket_bounce"]
    write_json(path, truth)
    effects = read(artifacts)["stroke_pro"].simulator.effects
    assert effects["racket_bounce"] == shipped("literature").effects["racket_bounce"]


def test_without_a_shot_there_is_one_error_that_says_what_to_do(tmp_path, capsys):
    far = [moved(shot_tables("plain", 3), ["py"], lambda column: column - 2.0)]
    artifacts = write_replays(tmp_path, far, sources=())
    with pytest.raises(InputError, match=r"let segment\.split\.replay keep more"):
        read(artifacts)
    assert f"no shot of plain can be replayed: 1 {FROM_NEAR}" in capsys.readouterr().err


@pytest.mark.real
def test_real_shots_come_to_the_robot(tmp_path, real_data):
    names = ["spindoe", "tt3d", "isr_ball_prediction", "competitive_robot_table_tennis"]
    run_ingest(tmp_path, real_data, names)
    run_segment(tmp_path)
    found = read(tmp_path / "artifacts", launches=100)
    assert {name: len(found[name]) > 10 for name in names} == dict.fromkeys(names, True)
    assert found["tt3d"].rotated > 0 == found["spindoe"].rotated
    for one in found.values():
        bounces = one.path[np.arange(len(one)), (one.playable[:, 0] / 0.001).astype(int)]
        assert (bounces[:, 1] < 0).all() and (np.abs(bounces[:, 0]) < 0.78).all()
        assert np.abs(bounces[:, 2]).max() < 0.06
        assert one.in_reach > 0.6 * len(one)
