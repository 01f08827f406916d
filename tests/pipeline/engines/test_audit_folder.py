"""An engine in; an audit, a list of effects and a page out."""

import json

import pytest
from typer.testing import CliRunner

from rallygap.pipeline.cli import app
from rallygap.pipeline.engines.audit_folder import audit_folder
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.gap.test_diagnose_folder import contents

FILES = ["audit.json", "figures/bounces.png", "figures/worth.png", "report.html", "simulator.yaml"]
MINE = """
gravity: {g: 9.81}
drag: {cd: 0.45}
magnus: {cm: -0.2}
table_bounce: {restitution: 0.88, friction: 0.3}
"""


def test_an_audit_has_the_list_its_traps_and_a_comparison_and_the_same_bytes_again(tmp_path):
    mine, out = tmp_path / "mine.yaml", tmp_path / "out"
    mine.write_text(MINE)
    words = ["audit", str(mine), "--against", "literature", "--out", str(out)]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    assert "Trap: Lift is inverse (C_M -0.2)" in result.output
    assert "Compared with literature, balls are " in result.output
    assert sorted(contents(out)) == FILES
    content = json.loads((out / "audit.json").read_text())
    assert [one["identifier"] for one in content["traps"]] == ["inverse_lift"]
    assert content["unexplained"]["table"]["largest_mm"] < 0.01
    assert content["against"]["effects"]["magnus.cm"] == 0.069
    assert content["against"]["flight_mm"] > 100.0
    found = load_simulator(str(out / "simulator.yaml"))
    assert found.to_dict() == load_simulator(str(mine)).to_dict()
    page = (out / "report.html").read_text()
    assert "Lift is inverse" in page and "Compared with another engine" in page
    said = audit_folder(str(mine), tmp_path / "again", "literature")
    assert "drag.cd 0.45 and 0.54" in said[-1] and "gravity.g" not in said[-1]
    assert contents(tmp_path / "again") == contents(out)


def test_an_engine_that_fails_leaves_nothing(tmp_path):
    (tmp_path / "mine.py").write_text("def fly(states, times):\n    return states\n")
    with pytest.raises(InputError, match="returns the shape"):
        audit_folder(f"{tmp_path / 'mine.py'}:fly", tmp_path / "out")
    assert not (tmp_path / "out").exists()
