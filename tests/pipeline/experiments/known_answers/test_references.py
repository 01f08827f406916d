"""Reference values come from the recordings, not from the simulator."""

import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.name.label_readings import without_labels
from rallygap.pipeline.experiments.known_answers.answers import (
    IDENTITIES,
    Diagnosis,
    reference_values,
    references,
)
from rallygap.pipeline.gap.measured_shots import read_shots
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.experiments.known_answers.made_up import shots
from tests.pipeline.recorded import write_recordings

NOMINAL = shipped("literature")


def test_reference_values_are_those_that_the_shots_were_made_with(tmp_path):
    write_recordings(tmp_path / "lab", shots=36)
    unlabelled = without_labels(read_shots(tmp_path / "lab", "csv").shots)
    off = {"drag.cd": 0.5, "gravity.g": 9.9, "table_bounce.restitution": 0.9, "spin_gain.s": 0.2}
    simulator = NOMINAL
    for identity, value in off.items():
        simulator = Hypothesis.from_identity(identity).at(simulator, value)
    values = reference_values(unlabelled, simulator)
    assert values.keys() == set(IDENTITIES)
    for identity, accuracy in {
        "drag.cd": 0.01,
        "gravity.g": 0.03,
        "table_bounce.restitution": 0.01,
    }.items():
        truth = Hypothesis.from_identity(identity).value(NOMINAL)
        assert values[identity] == pytest.approx(truth, abs=accuracy)
    assert values["wind.x"] == pytest.approx(0.0, abs=0.2)
    assert values["spin_gain.s"] == 0.2  # without labels, nothing is known about it


def test_reference_values_on_file_are_kept_and_a_broken_file_is_named(tmp_path):
    fold = Diagnosis(tmp_path / "0.references.json", shots(), NOMINAL)
    fold.file.write_text(str(dict.fromkeys(IDENTITIES, 1)).replace("'", '"'))
    assert references([fold]) == [dict.fromkeys(IDENTITIES, 1.0)]
    fold.file.write_text("{}")
    with pytest.raises(InputError, match=r"0\.references\.json: has no reference values; remove"):
        references([fold])
