"""Known answers: what is planted, what a correct verdict finds, and how answers are scored."""

import json
from collections import defaultdict
from dataclasses import replace

import joblib
import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import experiments.stages.known_answers as stage
from experiments import known_answers, resumed
from experiments.known_answers import (
    DISTORTION,
    IDENTITIES,
    IN_RECORDINGS,
    IN_SIMULATOR,
    Answer,
    PlantedError,
    Question,
    answer_table,
    plant,
    planted_errors,
    reference_values,
    references,
    set_scores,
    true_values,
)
from experiments.resumed import Diagnosis, verdicts
from rallygap.models.ball.sensor import clock_times, measured_positions, measured_spins
from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.hypotheses import Hypothesis, hypotheses
from rallygap.models.gap.name.label_readings import without_labels
from rallygap.pipeline.gap.measured_shots import read_shots
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from tests.experiments.made_up import TIMES, cause, found, shots
from tests.pipeline.recorded import write_recordings

BASE = shipped("literature")
REFERENCES = defaultdict(
    float, {"drag.cd": 0.54, "table_bounce.restitution": 0.99, "position_scale.s": 0.03}
)


def test_errors_have_rising_sizes_that_the_shots_can_show_and_none_is_implausible():
    limits = {"drag.cd": 0.02, "gravity.g": 0.1, "wind.x": 1.0}
    errors = list(planted_errors(limits))
    names = [Question("lab", 0, error).name for error in errors]
    assert len(set(names)) == len(names) == 3 * 3 + 2
    sizes = defaultdict(list)
    for error in errors:
        sizes[error.identity].append(error.value)
    assert sizes["gravity.g"] == pytest.approx([0.2, 0.4, 0.8])
    assert sizes["wind.x"] == pytest.approx([2.0, 4.0])
    assert sizes[DISTORTION] == [0.002, 0.004, 0.008]


def planted(identity, value, of=None, seed=1):
    error = PlantedError("recordings", identity, "medium", value)
    return plant(error, BASE, shots() if of is None else of, REFERENCES, seed)[1]


def at(simulator, values):
    for identity, value in values.items():
        simulator = Hypothesis.from_identity(identity).at(simulator, value)
    return simulator


def test_sensor_errors_are_what_a_sensor_with_the_effect_measures():
    before = shots()
    scaled, timed = planted("position_scale.s", 0.02), planted("clock_rate.d", 0.02)
    sensor = at(BASE, {"position_scale.s": 0.02})
    assert np.allclose(scaled.positions, measured_positions(sensor, before.positions))
    clock = at(BASE, {"clock_rate.d": 0.02})
    assert np.allclose(timed.times, clock_times(clock, before.times))
    assert np.allclose(timed.label_times, clock_times(clock, before.label_times))
    for identity in ("spin_axis_bias.x", "spin_gain.s"):
        labels = planted(identity, 0.2).labels
        assert np.allclose(labels, measured_spins(at(BASE, {identity: 0.2}), before.labels))
    turned, turn = planted("frame_tilt.y", 0.03), Rotation.from_rotvec([0.03, 0.0, 0.0])
    assert np.allclose(turned.positions[3], turn.apply(before.positions[3]))
    assert np.allclose(turned.labels[:, 0], turn.apply(before.labels[:, 0]))


def test_turned_recordings_are_those_of_a_tilted_world():
    angle = 0.03
    ball = np.array([0.1, 1.0, 0.3, 0.5, -6.0, 1.0, -100.0, 20.0, 30.0])
    turn = Rotation.from_rotvec([angle, 0.0, 0.0])
    turned = np.concatenate([turn.apply(ball[k : k + 3]) for k in (0, 3, 6)])
    error = PlantedError("recordings", "frame_tilt.y", "medium", angle)
    world = at(BASE, true_values(error, REFERENCES))
    times = 0.01 * np.arange(60)
    level, tilted = BASE.fly(ball, times), world.fly(turned, times)
    assert level.contacts.count[0] == 1
    expected = turn.apply(level.states[0, :, :3])
    assert np.abs(tilted.states[0, :, :3] - expected).max() < 2e-4


def test_a_distortion_is_smooth_has_its_size_and_follows_the_seed():
    places = np.random.default_rng(0).uniform(-20.0, 20.0, (3, len(TIMES), 3))
    shot = shots(recordings=3, each=1)

    def shift(size, aside=0.0, seed=1):
        at = places + np.array([aside, 0.0, 0.0])
        return planted(DISTORTION, size, replace(shot, positions=at), seed).positions - at

    here = shift(0.004)
    assert np.sqrt((here**2).mean()) == pytest.approx(0.004, rel=0.25)
    assert np.abs(shift(0.004, aside=0.05) - here).max() < 0.002
    assert np.allclose(shift(0.008), 2 * here)
    assert not np.allclose(shift(0.004, seed=2), here, atol=1e-3)


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


@pytest.mark.parametrize(
    ("identity", "value", "expected"),
    [
        ("position_scale.s", 0.02, {"position_scale.s": 1.5 * 1.02 - 1}),
        ("spin_axis_bias.x", 0.2, {"spin_axis_bias.x": 0.7}),
        ("frame_tilt.y", 0.02, {"frame_tilt.y": 0.52, "table_tilt.y": 0.48}),
    ],
)
def test_true_values_add_to_those_of_the_recordings(identity, value, expected):
    error = PlantedError("recordings", identity, "medium", value)
    assert true_values(error, defaultdict(lambda: 0.5)) == pytest.approx(expected)


def test_reference_values_are_those_that_the_shots_were_made_with(tmp_path):
    write_recordings(tmp_path / "lab", shots=36)
    unlabelled = without_labels(read_shots(tmp_path / "lab", "csv").shots)
    off = {"drag.cd": 0.5, "gravity.g": 9.9, "table_bounce.restitution": 0.9, "spin_gain.s": 0.2}
    simulator = at(BASE, off)
    values = reference_values(unlabelled, simulator)
    assert values.keys() == set(IDENTITIES)
    accuracies = {"drag.cd": 0.01, "gravity.g": 0.03, "table_bounce.restitution": 0.01}
    for identity, accuracy in {**accuracies, "wind.x": 0.2}.items():
        truth = Hypothesis.from_identity(identity).value(BASE)
        assert values[identity] == pytest.approx(truth, abs=accuracy)
    assert values["spin_gain.s"] == 0.2  # without labels, nothing is known about it


def test_files_of_a_killed_run_are_kept_and_broken_ones_are_named(tmp_path):
    fold = Diagnosis(tmp_path / "0.json", shots(), BASE)
    fold.file.write_text(json.dumps(dict.fromkeys(IDENTITIES, 1.0)))
    assert references([fold]) == [dict.fromkeys(IDENTITIES, 1.0)]
    fold.file.write_text("{}")
    with pytest.raises(InputError, match=r"0\.json: has no reference values; remove"):
        references([fold])
    with pytest.raises(InputError, match=r"0\.json: is no verdict; remove it"):
        verdicts([fold], "")


def test_a_planted_error_is_found_by_the_gap_workflow(tmp_path):
    write_recordings(tmp_path / "lab", shots=36)
    error = PlantedError("recordings", "position_scale.s", "medium", 0.02)
    lab = read_shots(tmp_path / "lab", "csv").shots
    simulator, planted = plant(error, BASE, lab, {}, seed=0)
    with joblib.parallel_config(backend="sequential"):
        (verdict,) = verdicts([Diagnosis(tmp_path / "0.json", planted, simulator)], "")
    assert verdict.main_causes[0].identity == "position_scale.s"
    assert verdict.main_causes[0].estimate == pytest.approx(0.02, rel=0.2)


class Expert:
    """Knows the physics, which is ``literature``; sees no error of recordings."""

    def __init__(self, killed_after=10_000):
        self.calls, self.killed_after = 0, killed_after

    def __call__(self, shots, simulator):
        if self.calls == self.killed_after:
            raise KeyboardInterrupt
        self.calls += 1
        wrong = [one for one in hypotheses(simulator) if one.value(simulator) != one.value(BASE)]
        causes = (
            cause(one.identity, one.value(BASE), one.value(simulator), margin=1e-4) for one in wrong
        )
        limits = dict.fromkeys([*IN_SIMULATOR, *IN_RECORDINGS], 0.01)
        return found(*causes).model_copy(update={"minimum_detectable": limits})


@pytest.fixture
def run(tmp_path_factory, monkeypatch):
    """Runs the stage with an expert on one measured set; returns the run."""
    sets = tmp_path_factory.mktemp("sets")
    write_recordings(sets / "csv", shots=8)
    monkeypatch.setenv("RALLYGAP_DATA", str(sets))
    monkeypatch.setattr(stage, "SETS", ["csv"])
    values = {one: Hypothesis.from_identity(one).value(BASE) for one in IDENTITIES}
    monkeypatch.setattr(known_answers, "reference_values", lambda *given: values)

    def run_stage(root, expert):
        monkeypatch.setattr(resumed, "diagnose", expert)
        started = StageRun("known_answers", root, None)
        with joblib.parallel_config(backend="sequential"):
            stage.known_answers(started)
        return started

    return run_stage


def test_a_killed_run_resumes_and_leaves_a_table_and_scores(run, tmp_path_factory):
    root, whole = tmp_path_factory.mktemp("killed"), Expert()
    with pytest.raises(KeyboardInterrupt):
        run(root, Expert(killed_after=10))
    again = Expert()
    resumed_run = run(root, again)
    (scores,) = json.loads(resumed_run.report("scores.json").read_text()).values()
    other = run(tmp_path_factory.mktemp("whole"), whole)
    for name in ("scores.json", "answers.csv"):
        assert other.report(name).read_bytes() == resumed_run.report(name).read_bytes()
    assert again.calls == whole.calls - 10
    assert scores["leading"] == scores["exact"] == 2 * 3 * len(IN_SIMULATOR)
    assert scores["coverage"] == 1.0
    assert scores["false_causes"] == 0
    assert (scores["unplanted"], scores["unplanted_clean"]) == (2, 2)
    assert (scores["distorted"], scores["distorted_clean"]) == (6, 6)
    table = pd.read_csv(other.report("answers.csv"))
    assert len(table) == scores["questions"] + scores["unplanted"] + scores["distorted"]
    rows = table[table["leading"].notna()]
    assert (rows["leading"].astype(bool) == (rows["place"] == "simulator")).all()


def test_too_few_shots_are_refused_before_anything_is_diagnosed(run, tmp_path, monkeypatch):
    monkeypatch.setattr(stage, "FOLDS", 3)
    with pytest.raises(InputError, match="csv: has a fold of fewer than 3 shots"):
        run(tmp_path, Expert(killed_after=0))


DRAG = PlantedError("simulator", "drag.cd", "medium", 0.1)
SPOILED = 0.64
WIND = cause("wind.x", 0.5, 0.0)


def answer(causes, before=(), error=DRAG):
    return Answer.of(Question("lab", 0, error), found(*causes), found(*before), REFERENCES)


TRUE_DRAG = cause("drag.cd", 0.545, SPOILED)
OTHER_WIND = cause("wind.x", 0.55, 0.0)
SCALE = PlantedError("recordings", "position_scale.s", "medium", 0.04)
TILT = PlantedError("simulator", "frame_tilt.x", "medium", 0.02)
EITHER = cause("wind.x", 0.5, 0.0, possible=("frame_tilt.y",))
KNOWN_SCALE = cause("position_scale.s", 0.03, 0.0)
FOUND_SCALE = cause("position_scale.s", 1.03 * 1.04 - 1, 0.0)
DISTORTED = cause("camera_distortion.amplitude", 0.004, 0.0, role="sensor")


def wind(role):
    return cause("wind.x", 0.5, 0.0, role=role)


@pytest.mark.parametrize(
    ("causes", "before", "error", "expected"),  # leading, by name, exact, covered, false
    [
        ([TRUE_DRAG], [], DRAG, (True, True, True, (True,), ())),
        ([], [], DRAG, (False, False, False, (), ())),
        # Causes of the unplanted verdict do not count, unless they have another value.
        ([WIND, TRUE_DRAG], [WIND], DRAG, (True, True, True, (True,), ())),
        ([OTHER_WIND, TRUE_DRAG], [WIND], DRAG, (False, False, False, (True,), (OTHER_WIND,))),
        # A cause behind the planted error leaves it leading.
        ([TRUE_DRAG, WIND], [], DRAG, (True, True, False, (True,), (WIND,))),
        # Faults of sensors are not false, and minor causes are none.
        ([TRUE_DRAG, wind("sensor")], [], DRAG, (True, True, False, (True,), ())),
        ([wind("minor"), TRUE_DRAG], [], DRAG, (True, True, True, (True,), ())),
        ([cause("drag.cd", 0.545, SPOILED, role="minor")], [], DRAG, (False, False, False, (), ())),
        # All recordings have a camera distortion.
        ([DISTORTED, TRUE_DRAG], [], DRAG, (True, True, True, (True,), ())),
        # A verdict that ignores what was planted is wrong.
        ([KNOWN_SCALE], [KNOWN_SCALE], SCALE, (False, False, False, (), ())),
        ([FOUND_SCALE], [KNOWN_SCALE], SCALE, (True, True, True, (True,), ())),
        # The truth is the reference value, also where the unplanted verdict has another.
        ([TRUE_DRAG], [cause("drag.cd", 0.5, 0.52)], DRAG, (True, True, True, (True,), ())),
        ([cause("drag.cd", 0.5, SPOILED)], [], DRAG, (True, True, True, (False,), ())),
        # An inseparable cause counts as the planted one, but has no interval for it.
        ([EITHER], [], TILT, (True, False, True, (), ())),
        ([cause("frame_tilt.y", 0.02, 0.0)], [], TILT, (True, True, True, (), ())),
    ],
)
def test_an_answer_is_right_if_planting_adds_the_error_and_nothing_else(
    causes, before, error, expected
):
    one = answer(causes, before, error)
    assert (one.leading, one.by_name, one.exact, one.covered, one.false) == expected


ANSWERS = [
    answer([WIND], error=None),
    answer([cause("wind.x", 0.5, 0.0, role="sensor")], error=None),
    answer([cause("drag.cd", 0.545, SPOILED)]),
    answer([cause("drag.cd", 0.6, SPOILED), WIND]),
    answer([]),
    answer([], error=PlantedError("recordings", DISTORTION, "small", 0.002)),
    answer([WIND], error=PlantedError("recordings", DISTORTION, "large", 0.008)),
]


def test_the_scores_of_a_set_count_its_questions():
    assert set_scores(ANSWERS) == {
        "questions": 3,
        "leading": 2,
        "by_name": 2,
        "exact": 1,
        "false_causes": 1,
        "intervals": 2,
        "covered": 1,
        "coverage": 0.5,
        "distorted": 2,
        "distorted_clean": 1,
        "unplanted": 2,
        "unplanted_clean": 1,
    }
    assert set_scores([answer([])])["coverage"] is None


def test_the_table_has_a_row_a_question():
    table = answer_table(ANSWERS)
    assert table["planted"].tolist() == ["none"] * 2 + ["drag.cd"] * 3 + [DISTORTION] * 2
    assert table["causes"][3] == "drag.cd 0.6 (0.59 to 0.61); wind.x 0.5 (0.49 to 0.51)"
    assert table["leading"].dropna().tolist() == [True, True, False]
    assert table["covered"].dropna().tolist() == [True, False]
    assert table["true"][2] == "drag.cd 0.54"
    assert table["false"].dropna().tolist() == ["", "wind.x", "", "", "wind.x"]
    assert table["before_mm"][0] == pytest.approx((9 + 21 + 40) / 3)
