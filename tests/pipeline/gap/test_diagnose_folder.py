"""A folder of recordings and a simulator in; a verdict, an amended simulator and a page out."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.settings import DEFAULTS
from rallygap.pipeline.gap import diagnose_folder as diagnosis
from rallygap.pipeline.gap.diagnose_folder import diagnose_folder, write_findings
from rallygap.pipeline.gap.expected_balls import read_expected
from rallygap.pipeline.gap.provenance import made_from
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.recorded import NOMINAL, write_recordings
from tests.pipeline.verdicts import CAMERA, CAMERA_NODES, MINOR, findings, verdict
from tests.pipeline.verdicts import WIND as WIND_CAUSE

ROOT = Path(__file__).parents[3]
WIND = {"wind": {"x": 0.6}}
FILES = ["amended.yaml", "balls.json", "figures/causes.png", "figures/discrepancy.png"]
FILES += ["figures/errors.png", "figures/growth.png", "report.html", "verdict.json"]


def files(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def rallygap(*words, cwd):
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [
        sys.executable,
        "-c",
        "from rallygap.pipeline.cli import main; main()",
        *map(str, words),
    ]
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True)


@pytest.fixture(scope="module")
def windy(tmp_path_factory):
    """The terminal after recordings with a hidden wind were diagnosed into ``out``."""
    folder = tmp_path_factory.mktemp("windy")
    write_recordings(folder / "lab", WIND, shots=36)
    shown = rallygap("diagnose", "lab", "--simulator", NOMINAL, "--out", "out", cwd=folder)
    return shown, folder / "out"


def test_a_hidden_effect_is_named_on_the_terminal_and_in_the_file(windy):
    shown, out = windy
    assert (shown.returncode, shown.stderr) == (0, "")
    limits, found = shown.stdout.split("\n\n")
    used, limits = limits.split("\n", 1)
    assert used.startswith("Used: 36 of 36 episodes in 36 recordings. Spin labels: 4,")
    assert limits.startswith("Minimum detectable effects (5.8 sigma) in 36 shots of lab:")
    assert "\n  wind.x " in limits
    assert found.startswith("Named: 36 shots of lab differ from")
    content = json.loads((out / "verdict.json").read_text())
    assert [one["identity"] for one in content["causes"]] == ["wind.x"]
    assert content["causes"][0]["estimate"] == pytest.approx(0.6, rel=0.1)
    origin = content["made_from"]
    names = [origin[key] for key in ("data", "folder", "recordings", "shots", "simulator")]
    assert names == ["lab", "lab", 36, 36, NOMINAL]
    assert origin["settings"] == {"level": 0.003}
    assert Simulator.from_dict(origin["effects"]) == load_simulator(NOMINAL)


def test_every_file_is_there_and_the_amended_simulator_is_one(windy):
    _, out = windy
    assert files(out) == FILES
    amended = load_simulator(str(out / "amended.yaml"))
    assert amended.effects["wind"]["x"] == pytest.approx(0.6, rel=0.1)
    assert read_expected(out / "balls.json").noise == pytest.approx(0.003, rel=0.1)
    assert "<h1>Verdict: named</h1>" in (out / "report.html").read_text()


def test_clean_recordings_have_no_gap(tmp_path):
    folder = write_recordings(tmp_path / "lab", shots=36)
    found = diagnose_folder(folder, "csv", NOMINAL, 0.003, tmp_path / "out")
    assert found.verdict.verdict == "no_gap"
    assert files(tmp_path / "out") == [
        "amended.yaml", "balls.json", "figures/errors.png", "figures/growth.png", "report.html",
        "verdict.json",
    ]  # fmt: skip
    assert load_simulator(str(tmp_path / "out/amended.yaml")) == load_simulator(NOMINAL)


MINE = """
from rallygap.models.ball.simulators import shipped

def fly(states, times):
    return shipped("literature").fly(states, times).states
"""


def test_a_function_is_audited_diagnosed_and_given_back_as_code(tmp_path):
    folder, said = write_recordings(tmp_path / "lab", WIND, shots=36), []
    (tmp_path / "mine.py").write_text(MINE)
    name = f"{tmp_path / 'mine.py'}:fly"
    found = diagnose_folder(folder, "csv", name, 0.003, tmp_path / "out", said.append)
    assert f"{name} has 5 parameters" in said[0]
    assert [one.identity for one in found.verdict.causes] == ["wind.x"]
    assert files(tmp_path / "out") == sorted([*FILES, "ball_effects.py"])
    code = (tmp_path / "out" / "ball_effects.py").read_text()
    assert "wind.x: missing before; estimated" in code and "def fly(states, times):" in code
    write_findings(findings(), tmp_path / "out")
    assert "ball_effects.py" not in files(tmp_path / "out")


def test_minor_structure_is_amended_on_request_only(tmp_path):
    found = findings(verdict(causes=(WIND_CAUSE, MINOR)))
    for minor in (False, True):
        write_findings(replace(found, minor=minor), tmp_path)
        amended = load_simulator(str(tmp_path / "amended.yaml")).effects
        assert ("spin_decay" in amended) == minor
        assert amended["wind"]["x"] == WIND_CAUSE.estimate


def test_doubts_about_recordings_are_limitations_of_the_verdict(tmp_path, monkeypatch):
    folder, said = write_recordings(tmp_path / "lab", shots=6, time_resolution=1e-3), []
    monkeypatch.setattr(diagnosis, "diagnose", lambda *arguments, **named: verdict())
    found = diagnose_folder(folder, "csv", NOMINAL, 0.003, tmp_path / "out", said.append)
    (doubt,) = (line for line in said if "rounded to 1 ms" in line)
    assert doubt == f"Doubtful: {found.verdict.limitations[0]}."
    assert found.verdict.limitations[1:] == verdict().limitations


def test_a_verdict_keeps_the_settings_that_differ_from_the_default():
    settings = replace(DEFAULTS, level=0.01, fit=replace(DEFAULTS.fit, refit_steps=9))
    nominal = load_simulator(NOMINAL)
    origin = made_from("lab", "takes", (3, 40), nominal, "/home/me/sim.yaml", settings)
    assert origin.settings == {"level": 0.01, "fit.refit_steps": 9}
    assert (origin.simulator, origin.effects) == ("sim.yaml", nominal.to_dict())


def test_an_error_of_the_cameras_has_a_figure_until_a_verdict_without_it(tmp_path):
    write_findings(findings(verdict(causes=(CAMERA,), camera=CAMERA_NODES)), tmp_path)
    assert "figures/camera.png" in files(tmp_path)
    write_findings(findings(), tmp_path)
    assert "figures/camera.png" not in files(tmp_path)


def test_a_later_verdict_replaces_an_earlier_one_and_nothing_else(tmp_path):
    write_findings(findings(), tmp_path)
    (tmp_path / "notes.txt").write_text("mine")
    write_findings(findings(verdict("no_gap", (), gap=None)), tmp_path)
    assert files(tmp_path) == [
        "amended.yaml", "balls.json", "notes.txt", "report.html", "verdict.json",
    ]  # fmt: skip


def test_same_findings_same_bytes(tmp_path):
    for name in ("first", "second"):
        write_findings(findings(), tmp_path / name)
    for file in FILES:
        assert (tmp_path / "first" / file).read_bytes() == (tmp_path / "second" / file).read_bytes()


def test_a_failure_leaves_the_earlier_verdict(tmp_path, monkeypatch):
    write_findings(findings(), tmp_path)
    before = {name: (tmp_path / name).read_bytes() for name in files(tmp_path)}

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(diagnosis, "render_gap_page", fail)
    with pytest.raises(InputError, match="cannot be written to: No space left"):
        write_findings(findings(verdict("no_gap", ())), tmp_path)
    assert {name: (tmp_path / name).read_bytes() for name in files(tmp_path)} == before


def test_a_file_that_is_no_recording_is_refused_in_one_line(tmp_path):
    folder = write_recordings(tmp_path / "lab", shots=3)
    (folder / "001.csv").write_text("time,x,y,z\n0,0,1,0.3\n")
    refused = rallygap("diagnose", folder, "--simulator", NOMINAL, "--out", "out", cwd=tmp_path)
    assert refused.returncode == 2
    assert refused.stderr.startswith(f"rallygap: {folder / '001.csv'}, row 1")
    assert len(refused.stderr.splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_too_few_shots_are_refused_before_anything_is_written(tmp_path):
    folder = write_recordings(tmp_path / "lab", shots=2)
    with pytest.raises(InputError, match=r"lab: 2 of its 2 episodes are .* at least 3"):
        diagnose_folder(folder, "csv", NOMINAL, 0.003, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_simulator_without_a_table_is_refused_where_balls_bounce(tmp_path):
    folder = write_recordings(tmp_path / "lab", shots=6)
    (tmp_path / "air.yaml").write_text("gravity: {g: 9.81}\n")
    with pytest.raises(InputError, match=r"air.yaml, table_bounce: is missing, but \d of the"):
        diagnose_folder(folder, "csv", str(tmp_path / "air.yaml"), 0.003, tmp_path / "out")


def test_a_file_in_place_of_the_output_folder_is_refused(tmp_path):
    (tmp_path / "out").write_text("mine")
    with pytest.raises(InputError, match="out: is a file; give a folder"):
        diagnose_folder(tmp_path, "csv", NOMINAL, 0.003, tmp_path / "out")
    assert (tmp_path / "out").read_text() == "mine"
