"""The methods of the exam, and the gap workflow's answer."""

import numpy as np
import pytest

from models.exam.interface import rounded, shots_of
from models.exam.methods.registry import METHODS
from models.exam.simulate.recordings import simulate_trial
from models.gap.amend.simulator import amended
from models.gap.diagnose import diagnose
from tests.models.exam.example_trials import NOMINAL, trial


def test_the_workflow_is_compared_with_three_others():
    assert list(METHODS) == ["rallygap", "sindy", "sindy_ensemble", "identification"]


def test_recordings_become_shots_with_their_labels():
    recordings, _ = simulate_trial(trial(shots=5, spin_labels="per_shot"))
    shots = shots_of(recordings)
    assert len(shots) == 5
    assert (shots.labelled.sum(axis=1) <= 1).all()
    assert np.array_equal(shots.positions[2][shots.valid[2]], recordings[2].positions)


@pytest.mark.slow
def test_the_workflows_answer_is_its_verdict():
    asked = trial(shots=30, seed=1004, causes={"table_bounce": {"restitution": 0.80}})
    recordings, _ = simulate_trial(asked)
    answer = METHODS["rallygap"](recordings, NOMINAL, ("wind",))
    verdict = diagnose(shots_of(recordings), NOMINAL, withheld=("wind",))
    named, cause = answer.causes[0], verdict.causes[0]
    assert named.identity == "table_bounce.restitution"
    assert (answer.conclusion, named.possible) == (verdict.verdict, cause.possible)
    assert named.estimate == rounded(cause.estimate)
    assert named.interval == tuple(rounded(end) for end in cause.interval)
    assert answer.amended == amended(NOMINAL, verdict)
