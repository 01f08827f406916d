"""Methods: the exam asks them all the same, and the workflow answers as its verdict does."""

import numpy as np
import pytest

from models.exam.answer import shots_of
from models.exam.methods.registry import METHODS
from models.exam.simulate.recordings import held
from models.gap.amend.simulator import amended
from models.gap.diagnose import diagnose
from tests.models.exam.halls import NOMINAL, trial


def test_the_workflow_is_compared_with_three_others():
    assert list(METHODS) == ["rallygap", "sindy", "sindy_ensemble", "identification"]


def test_recordings_become_shots_with_their_labels():
    recordings, _ = held(trial(shots=5, spin_labels="per_shot"))
    shots = shots_of(recordings)
    assert len(shots) == 5
    assert (shots.labelled.sum(axis=1) <= 1).all()
    assert np.array_equal(shots.positions[2][shots.valid[2]], recordings[2].positions)


@pytest.mark.slow
def test_the_workflows_finding_is_its_verdict():
    hall = trial(shots=30, seed=1004, causes={"table_bounce": {"restitution": 0.80}})
    recordings, _ = held(hall)
    found = METHODS["rallygap"](recordings, NOMINAL, ("wind",))
    verdict = diagnose(shots_of(recordings), NOMINAL, withheld=("wind",))
    cause, said = found.causes[0], verdict.causes[0]
    assert (cause.name, cause.effect, cause.parameter) == (
        "restitution",
        "table_bounce",
        "restitution",
    )
    assert (found.answer, cause.possible) == (verdict.verdict, ("restitution",))
    assert (cause.estimate, cause.interval) == (said.estimate, said.interval)
    assert found.amended == amended(NOMINAL, verdict)
