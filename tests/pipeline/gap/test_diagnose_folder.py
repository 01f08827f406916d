"""A folder of recordings and a simulator in; a verdict, an amended simulator and a page out."""

import json
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from rallygap.models.ball.simulator import Simulator
from rallygap.pipeline.cli import app
from rallygap.pipeline.gap import diagnose_folder as diagnosis
from rallygap.pipeline.gap.diagnose_folder import diagnose_folder, write_findings
from rallygap.pipeline.gap.expected_balls import read_expected
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.recorded import NOMINAL, write_recordings
from tests.pipeline.verdicts import CAMERA, CAMERA_NODES, MINOR, findings, verdict

FILES = ["amended.yaml", "balls.json", "figures/causes.png", "figures/discrepancy.png"]
FILES += ["figures/errors.png", "figures/growth.png", "report.html", "verdict.json"]
MINE = """
from rallygap.models.ball.simulators import shipped

def fly(states, times):
    return shipped("literature").fly(states, times).states
"""


def files(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def contents(folder):
    return {name: (folder / name).read_bytes() for name in files(folder)}


def test_a_hidden_effect_is_named_on_the_terminal_and_in_the_files(tmp_path):
    lab = write_recordings(tmp_path / "lab", {"wind": {"x": 0.6}}, shots=36)
    out = tmp_path / "out"
    words = ["diagnose", str(lab), "--simulator", NOMINAL, "--out", str(out)]
    shown = CliRunner().invoke(app, words, catch_exceptions=False)
    assert (shown.exit_code, shown.stderr) == (0, "")
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
    assert files(out) == FILES
    amended = load_simulator(str(out / "amended.yaml"))
    assert amended.effects["wind"]["x"] == pytest.approx(0.6, rel=0.1)
    assert read_expected(out / "balls.json").noise == pytest.approx(0.003, rel=0.1)
    assert "<h1>Verdict: named</h1>" in (out / "report.html").read_text()


def test_clean_recordings_have_no_gap(tmp_path):
    folder, out = write_recordings(tmp_path / "lab", shots=24), tmp_path / "out"
    found = diagnose_folder(folder, "csv", NOMINAL, 0.003, out)
    assert found.verdict.verdict == "no_gap"
    assert set(FILES) - set(files(out)) == {"figures/causes.png", "figures/discrepancy.png"}
    assert load_simulator(str(out / "amended.yaml")) == load_simulator(NOMINAL)


def test_a_function_is_audited_and_given_back_as_code_with_doubts_as_limitations(
    tmp_path, monkeypatch
):
    folder = write_recordings(tmp_path / "lab", shots=6, time_resolution=1e-3)
    out, said = tmp_path / "out", []
    (tmp_path / "mine.py").write_text(MINE)
    name = f"{tmp_path / 'mine.py'}:fly"
    monkeypatch.setattr(diagnosis, "diagnose", lambda *arguments, **named: verdict())
    found = diagnose_folder(folder, "csv", name, 0.003, out, said.append)
    assert f"{name} has 5 parameters" in said[0]
    (doubt,) = (line for line in said if "rounded to 1 ms" in line)
    assert doubt == f"Doubtful: {found.verdict.limitations[0]}."
    assert found.verdict.limitations[1:] == verdict().limitations
    assert found.verdict.made_from.simulator == "mine.py:fly"
    assert files(out) == sorted([*FILES, "ball_effects.py"])
    code = (out / "ball_effects.py").read_text()
    assert "wind.x: missing before; estimated" in code and "def fly(states, times):" in code
    write_findings(findings(), out)
    assert files(out) == FILES


def test_a_later_verdict_replaces_an_earlier_one_with_minor_structure_and_nothing_else(tmp_path):
    earlier = findings(verdict(causes=(CAMERA, MINOR), camera=CAMERA_NODES))
    write_findings(replace(earlier, minor=True), tmp_path)
    assert "figures/camera.png" in files(tmp_path)
    assert "spin_decay" in load_simulator(str(tmp_path / "amended.yaml")).effects
    (tmp_path / "notes.txt").write_text("mine")
    write_findings(findings(verdict("no_gap", (), gap=None)), tmp_path)
    assert files(tmp_path) == [
        "amended.yaml", "balls.json", "notes.txt", "report.html", "verdict.json",
    ]  # fmt: skip


def test_same_findings_same_bytes_and_a_failure_leaves_them(tmp_path, monkeypatch):
    for name in ("first", "second"):
        write_findings(findings(), tmp_path / name)
    before = contents(tmp_path / "first")
    assert before == contents(tmp_path / "second")

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(diagnosis, "render_gap_page", fail)
    with pytest.raises(InputError, match="cannot be written to: No space left"):
        write_findings(findings(verdict("no_gap", ())), tmp_path / "first")
    assert contents(tmp_path / "first") == before


@pytest.mark.parametrize(
    ("shots", "file", "content", "problem"),
    [
        (3, "lab/001.csv", "time,x,y,z\n0,0,1,0.3\n", r"001.csv, row 1"),
        (2, "sim.yaml", "", r"lab: 2 of its 2 episodes are .* at least 3"),
        (6, "sim.yaml", "gravity: {g: 9.81}\n", r"sim.yaml, table_bounce: is missing, but \d of"),
        (0, "out", "mine", "out: is a file; give a folder"),
    ],
)
def test_what_cannot_be_diagnosed_is_refused_before_anything_is_written(
    tmp_path, shots, file, content, problem
):
    if shots:
        write_recordings(tmp_path / "lab", shots=shots)
    (tmp_path / file).write_text(content)
    simulator = str(tmp_path / file) if file == "sim.yaml" and content else NOMINAL
    before = contents(tmp_path)
    with pytest.raises(InputError, match=problem) as refused:
        diagnose_folder(tmp_path / "lab", "csv", simulator, 0.003, tmp_path / "out")
    assert "\n" not in str(refused.value)
    assert contents(tmp_path) == before
