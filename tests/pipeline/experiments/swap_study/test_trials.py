"""The trials of the study, with a policy that chases the ball."""

import numpy as np
import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.models.predictors.physics import PhysicsPredictor
from rallygap.pipeline.experiments.swap_study.trials import (
    OF_MECHANISM,
    SETTINGS,
    mechanism_trials,
    played,
    reading_trials,
)
from rallygap.pipeline.transfer.replay_sets import read_replay_sets
from tests.pipeline.replayed import LAUNCH, launched, write_replays
from tests.pipeline.replayed import SETTINGS as REPLAY
from tests.pipeline.trained_policies import chaser, description

PREDICTORS = {name: PhysicsPredictor(shipped("literature")) for name in OF_MECHANISM}
POLICIES = [(chaser(), description()), (chaser(3.0), description(repeat=1))]


@pytest.fixture(scope="module")
def shots(tmp_path_factory):
    states = LAUNCH + np.array([[0.0], [0.01]])
    root = tmp_path_factory.mktemp("replayed")
    folder = write_replays(root, sources=("plain",), launches=launched(*states))
    return read_replay_sets(folder, REPLAY, 0)[-1]


def test_all_predictors_forecast_once_and_at_every_control_step(shots):
    trials = reading_trials(shots, PREDICTORS, POLICIES, 0)
    kinds = [(one.forecaster.name, one.forecaster.mode) for one in trials]
    assert len(set(kinds)) == len(kinds) == 2 * len(PREDICTORS)


def test_outcomes_have_their_recording_and_setting(shots):
    trial = reading_trials(shots, PREDICTORS, POLICIES, 0)[-1]
    table = played(trial, {"every_ms": "40"})
    assert table["recording"].tolist() == [*shots.recordings, *shots.recordings]
    assert table["repeat"].tolist() == [0, 0, 1, 1]
    assert set(table["every_ms"]) == {"40"}
    assert set(table["observation"]) == {POLICIES[0][1].observation}
    assert table["hit"].any()


def test_settings_differ_in_age_latency_and_labels(shots):
    found = list(mechanism_trials(shots, PREDICTORS, POLICIES, 0))
    assert len(found) == len(SETTINGS) * len(OF_MECHANISM)
    plain = next(trial for setting, trial in found if not setting.label_error)
    wrong = [trial for setting, trial in found if setting.label_error]
    states = [one.histories.history.states for one in (plain, *wrong)]
    assert np.abs(states[0] - states[1]).max() > 1
    for one in states[2:]:
        np.testing.assert_array_equal(one, states[1])
    assert {trial.latency for _, trial in found} == {0.0, 0.04, 0.1, 0.2}


def test_a_late_arm_hits_fewer_balls(shots):
    hits = {
        setting.latency_ms: trial.run().table["hit"].sum()
        for setting, trial in mechanism_trials(shots, PREDICTORS, POLICIES, 0)
        if setting.every_ms == 40 and not setting.label_error
    }
    assert hits[0] > hits[200]
