"""The stage on shots whose verdicts are made up, and on some whose physics is known."""

import pytest

from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.amend.simulator import amended
from rallygap.models.gap.verdict import Verdict
from rallygap.pipeline.gap import cases as gap_cases
from rallygap.pipeline.io.amended_simulators import amended_by
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.params import CloseGapSettings, ComparedSimulatorSettings
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.stages.close_gap import close_gap
from tests.pipeline.measured_shots import params, shot_tables, write_inputs
from tests.pipeline.verdicts import WIND, verdict
from tests.stages.outputs import table, written

SIMULATORS = {
    "c": ComparedSimulatorSettings(simulator="imperfect_c", without=[]),
    "bare": ComparedSimulatorSettings(simulator="imperfect_c", without=["magnus"]),
}
SETTINGS = CloseGapSettings(simulators=SIMULATORS, splits=2, shots=5, level=0.003)


def prepared(root, shots=4, split="train"):
    """A run on shots of a source with labels and of one without."""
    drawn = [
        shot_tables(source, 3 + number, split=split)
        for source in ("labelled", "plain")
        for number in range(shots)
    ]
    write_inputs(root, shots=drawn, sources=("labelled", "plain"))
    return StageRun("close_gap", root, params(close_gap=SETTINGS))


def windy(shots, simulator, settings, nets):
    """A verdict on a wind that grows with the simulator's lift."""
    strength = 0.5 + simulator.effects.get("magnus", {"cm": 0.0})["cm"]
    return verdict(causes=[WIND.model_copy(update={"estimate": strength})])


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A run with made-up verdicts; not to be changed."""
    run = prepared(tmp_path_factory.mktemp("whole"))
    close(run)
    return run


def close(run):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LOKY_MAX_CPU_COUNT", "1")  # in this process, where the patch holds
        patch.setattr(gap_cases, "diagnose", windy)
        close_gap(run)


def test_every_case_leaves_its_verdict_and_its_amended_simulator(whole):
    names = {
        f"{source}-{simulator}-{split}"
        for source in ("labelled", "plain")
        for simulator in SIMULATORS
        for split in range(2)
    }
    files = {path.name for path in whole.artifact(".").iterdir()}
    assert files == {"report", *(f"{name}.{kind}" for name in names for kind in ("yaml", "json"))}
    found = Verdict.load(whole.artifact("plain-c-1.json"))
    assert amended_by(whole.artifact(""), "plain", "c") == amended(shipped("imperfect_c"), found)
    assert "magnus" not in amended_by(whole.artifact(""), "plain", "bare").effects
    origin = Verdict.load(whole.artifact("plain-bare-1.json")).made_from
    assert (origin.data, origin.folder, origin.simulator) == ("plain", None, "bare")
    assert (origin.recordings, origin.shots, origin.settings) == (4, 4, {"level": 0.003})
    assert "magnus" not in origin.effects


def test_the_report_has_a_row_a_case_and_metrics_are_means_over_splits(whole):
    assert table(whole, "verdicts")["verdict"].tolist() == 8 * ["named"]
    again = table(whole, "stability")
    assert (again["found"] == again["splits"]).all()
    means = {name: {"causes": 1.0, "removable_closed": 0.9} for name in SIMULATORS}
    metrics = read_json(whole.report("metrics.json"))
    assert metrics == {"labelled": means, "plain": means}


def test_the_same_inputs_give_the_same_bytes(whole, tmp_path):
    again = prepared(tmp_path)
    close(again)
    assert written(again) == written(whole)


@pytest.mark.parametrize(
    ("split", "left"),
    [("train", "labelled has 2 unbroken training shots; give at least 3"), ("test", "")],
)
def test_too_few_shots_and_shots_that_are_for_tests_name_nothing(tmp_path, capsys, split, left):
    run = prepared(tmp_path, shots=2 if left else 4, split=split)
    with pytest.raises(InputError, match="no source has 3 unbroken shots"):
        close(run)
    assert left in capsys.readouterr().err
    assert not run.report(".").exists()
