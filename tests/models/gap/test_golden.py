"""Verdicts on fixed questions of the exam, one of most groups, stay as they are.

A change of structure must not change them. Where a change is meant, delete golden.json, run this
test, and say in the commit which verdicts changed and why.
"""

import hashlib
import json
from pathlib import Path

import pytest

from experiments.exam.design.detection_limits import DetectionLimits
from experiments.exam.design.questions import exam
from experiments.exam.interface import rounded, shots_of
from experiments.exam.simulate.recordings import simulate_trial
from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.diagnose import diagnose

GOLDEN = Path(__file__).with_name("golden.json")
SEED = 7
GROUPS = [
    "sweep", "clean", "pair", "sensor_fault", "nominal_off", "withheld", "unlabelled",
    "one_direction", "label_kind", "distortion", "drift", "place", "several", "far_off",
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("group", GROUPS)
def test_a_verdict_stays_as_it_is(group):
    questions = exam(shipped("literature"), SEED)
    question = next(question for question in questions if question.group == group)
    limits = DetectionLimits.of(question.trial) if question.hidden else None
    trial = question.posed(limits.minimum_sizes(question.hidden) if limits else ())
    recordings, _ = simulate_trial(trial)
    verdict = diagnose(shots_of(recordings), trial.nominal, withheld=trial.withheld)
    # Numbers to six digits: further ones differ between processors.
    content = json.loads(verdict.to_json(), parse_float=lambda digits: rounded(float(digits)))
    digest = hashlib.sha256(json.dumps(content).encode()).hexdigest()
    golden = json.loads(GOLDEN.read_text()) if GOLDEN.exists() else {}
    if group not in golden:
        GOLDEN.write_text(json.dumps(golden | {group: digest}, indent=2) + "\n")
        pytest.fail(f"the verdict of {group} is written to {GOLDEN.name}")
    assert digest == golden[group]
