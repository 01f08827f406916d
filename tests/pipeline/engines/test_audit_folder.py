"""An engine in; an audit, a list of effects and a page out."""

import json

import pytest
from typer.testing import CliRunner

from rallygap.pipeline.cli import app
from rallygap.pipeline.engines.audit_folder import audit_folder
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.runtime.errors import InputError

FILES = ["audit.json", "figures/bounces.png", "figures/worth.png", "report.html", "simulator.yaml"]
MINE = """
gravity: {g: 9.81}
drag: {cd: 0.45}
magnus: {cm: -0.2}
table_bounce: {restitution: 0.88, friction: 0.3}
"""


def files(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def test_an_audit_has_the_list_and_its_traps(tmp_path):
    (tmp_path / "mine.yaml").write_text(MINE)
    result = CliRunner().invoke(
        app, ["audit", str(tmp_path / "mine.yaml"), "--out", str(tmp_path / "out")]
    )
    assert result.exit_code == 0, result.output
    assert "Trap: Lift is inverse (C_M -0.2)" in result.output
    assert files(tmp_path / "out") == FILES
    content = json.loads((tmp_path / "out" / "audit.json").read_text())
    assert [one["identifier"] for one in content["traps"]] == ["inverse_lift"]
    assert content["unexplained"]["table"]["largest_mm"] < 0.01
    found = load_simulator(str(tmp_path / "out" / "simulator.yaml"))
    assert found.to_dict() == load_simulator(str(tmp_path / "mine.yaml")).to_dict()
    assert "Lift is inverse" in (tmp_path / "out" / "report.html").read_text()


def test_two_engines_are_compared(tmp_path):
    (tmp_path / "mine.yaml").write_text(MINE)
    said = audit_folder(str(tmp_path / "mine.yaml"), tmp_path / "out", "literature")
    assert said[-2].startswith("Compared with literature, balls are ")
    assert "drag.cd 0.45 and 0.54" in said[-1] and "gravity.g" not in said[-1]
    content = json.loads((tmp_path / "out" / "audit.json").read_text())["against"]
    assert content["effects"]["magnus.cm"] == 0.069 and content["flight_mm"] > 100.0
    assert "Compared with another engine" in (tmp_path / "out" / "report.html").read_text()


def test_the_same_engine_gives_the_same_bytes(tmp_path):
    for name in ("first", "second"):
        audit_folder("literature", tmp_path / name)
    for file in FILES:
        assert (tmp_path / "first" / file).read_bytes() == (tmp_path / "second" / file).read_bytes()


def test_an_engine_that_fails_leaves_nothing(tmp_path):
    (tmp_path / "mine.py").write_text("def fly(states, times):\n    return states\n")
    with pytest.raises(InputError, match="returns the shape"):
        audit_folder(f"{tmp_path / 'mine.py'}:fly", tmp_path / "out")
    assert not (tmp_path / "out").exists()
