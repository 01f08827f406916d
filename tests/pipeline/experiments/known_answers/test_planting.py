"""Planted recordings are what the sensor or the tilted world of the catalogue would deliver."""

from collections import defaultdict

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rallygap.models.ball.sensor import clock_times, measured_positions, measured_spins
from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.pipeline.experiments.known_answers.design import (
    DISTORTION,
    IN_SIMULATOR,
    PlantedError,
    plant,
    planted_errors,
    true_values,
)
from tests.pipeline.experiments.known_answers.made_up import shots

BASE = shipped("literature")
REFERENCES = defaultdict(float, {"drag.cd": 0.5, "table_bounce.restitution": 0.99})


def planted(identity, value, of=None):
    error = PlantedError("recordings", identity, "medium", value)
    return plant(error, BASE, shots() if of is None else of, REFERENCES, seed=1)[1]


def amended(identity, value):
    return Hypothesis.from_identity(identity).at(BASE, value)


def test_sensor_errors_are_what_a_sensor_with_the_effect_measures():
    before = shots()
    scaled, timed = planted("position_scale.s", 0.02), planted("clock_rate.d", 0.02)
    sensor = amended("position_scale.s", 0.02)
    assert np.allclose(scaled.positions, measured_positions(sensor, before.positions))
    clock = amended("clock_rate.d", 0.02)
    assert np.allclose(timed.times, clock_times(clock, before.times))
    assert np.allclose(timed.label_times, clock_times(clock, before.label_times))
    for identity in ("spin_axis_bias.x", "spin_gain.s"):
        labels = planted(identity, 0.2).labels
        assert np.allclose(labels, measured_spins(amended(identity, 0.2), before.labels))


def test_turned_recordings_are_those_of_a_tilted_world():
    angle = 0.03
    ball = np.array([0.1, 1.0, 0.3, 0.5, -6.0, 1.0, -100.0, 20.0, 30.0])
    turn = Rotation.from_rotvec([angle, 0.0, 0.0])
    turned = np.concatenate([turn.apply(ball[k : k + 3]) for k in (0, 3, 6)])
    world = BASE
    error = PlantedError("recordings", "frame_tilt.y", "medium", angle)
    for identity, value in true_values(error, REFERENCES).items():
        world = Hypothesis.from_identity(identity).at(world, value)

    times = 0.01 * np.arange(60)
    level, tilted = BASE.fly(ball, times), world.fly(turned, times)
    assert level.contacts.count[0] == 1
    expected = turn.apply(level.states[0, :, :3])
    assert np.abs(tilted.states[0, :, :3] - expected).max() < 2e-4


def test_a_turn_turns_positions_and_labels_alike():
    before, after = shots(), planted("frame_tilt.y", 0.03)
    turn = Rotation.from_rotvec([0.03, 0.0, 0.0])
    assert np.allclose(after.positions[3], turn.apply(before.positions[3]))
    assert np.allclose(after.labels[:, 0], turn.apply(before.labels[:, 0]))
    assert np.isnan(planted("frame_tilt.y", 0.03, shots(labelled=False)).labels).all()


def test_a_distortion_is_smooth_has_its_size_and_follows_the_seed():
    random = np.random.default_rng(0)
    before = shots(recordings=3, each=1)
    places = random.uniform(-20.0, 20.0, before.positions.shape)
    here = planted(DISTORTION, 0.004, _at(before, places)).positions - places
    aside = places + np.array([0.05, 0.0, 0.0])
    near = planted(DISTORTION, 0.004, _at(before, aside)).positions - aside
    assert np.sqrt((here**2).mean()) == pytest.approx(0.004, rel=0.25)
    assert np.abs(near - here).max() < 0.002
    twice = planted(DISTORTION, 0.008, _at(before, places)).positions - places
    assert np.allclose(twice, 2 * here)
    error = PlantedError("recordings", DISTORTION, "medium", 0.004)
    other = plant(error, BASE, _at(before, places), REFERENCES, seed=2)[1].positions - places
    assert not np.allclose(other, here, atol=1e-3)


def _at(some, places):
    return type(some)(**{**vars(some), "positions": places})


def test_an_error_in_the_simulator_changes_the_reference_value_of_one_number_within_its_range():
    for error in planted_errors(dict.fromkeys(IN_SIMULATOR, 0.02)):
        if error.place == "simulator":
            spoiled, same = plant(error, BASE, shots(), REFERENCES, seed=1)
            assert np.array_equal(same.positions, shots().positions)
            hypothesis = Hypothesis.from_identity(error.identity)
            reference = REFERENCES[error.identity]
            change = hypothesis.value(spoiled) - reference
            assert abs(change) == pytest.approx(error.value)
            restored, about = (hypothesis.at(one, reference) for one in (spoiled, BASE))
            assert np.array_equal(restored.vector, about.vector)


def test_nothing_is_planted_in_an_unplanted_question():
    simulator, same = plant(None, BASE, shots(), REFERENCES, seed=1)
    assert simulator is BASE
    assert np.array_equal(same.positions, shots().positions)


@pytest.mark.parametrize(
    ("place", "identity", "value", "expected"),
    [
        ("simulator", "drag.cd", 0.1, {"drag.cd": 0.5}),
        ("recordings", "position_scale.s", 0.02, {"position_scale.s": 1.5 * 1.02 - 1}),
        ("recordings", "spin_axis_bias.x", 0.2, {"spin_axis_bias.x": 0.7}),
        ("recordings", "frame_tilt.y", 0.02, {"frame_tilt.y": 0.52, "table_tilt.y": 0.48}),
        ("recordings", DISTORTION, 0.004, {}),
    ],
)
def test_true_values_add_to_those_of_the_recordings(place, identity, value, expected):
    error = PlantedError(place, identity, "medium", value)
    assert true_values(error, defaultdict(lambda: 0.5)) == pytest.approx(expected)
