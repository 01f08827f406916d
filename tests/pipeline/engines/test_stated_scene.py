"""Audits of scenes: what the file says next to what the scene does."""

import json

import pytest

pytest.importorskip("mujoco")

from rallygap.pipeline.engines.audit_folder import audit_folder
from tests.models.engines.mujoco.scenes import BALL, CONTACT, SHELL, TABLE, ball, written

COEFFICIENTS = 'fluidshape="ellipsoid" fluidcoef=".47 0 0 0 .069"'  # as one would read them
SOFT = CONTACT.replace("-1000000 -47", "-250000 -23")  # as its time step is long
NATURAL = TABLE + ball(f"{BALL} {SHELL} {SOFT} {COEFFICIENTS}")


def test_the_natural_reading_of_a_scene_is_named_with_its_cost_and_variants(tmp_path):
    (tmp_path / "scene.xml").write_text(
        written(NATURAL, 'timestep=".002" integrator="RK4" density="1.2"')
    )
    said = audit_folder(str(tmp_path / "scene.xml"), tmp_path / "out")
    assert any(line.startswith("Trap: Lift is inverse (C_M -0.431)") for line in said)
    assert any(line.startswith("Note: C_D is 0.94") for line in said)
    page = (tmp_path / "out" / "report.html").read_text()
    assert "What the file says" in page and "0.94" in page
    content = json.loads((tmp_path / "out" / "audit.json").read_text())
    says, does = content["says"], {one["identity"]: one["value"] for one in content["effects"]}
    assert says["drag"]["cd"] == pytest.approx(0.94)
    assert does["drag.cd"] == pytest.approx(0.94, abs=1e-3)
    assert does["magnus.cm"] == pytest.approx(says["magnus"]["cm"], abs=1e-3)
    restitution = does["table_bounce.restitution"]
    assert restitution == pytest.approx(says["table_bounce"]["restitution"], abs=0.02)
    variants = content["variants"]
    assert [one["name"] for one in variants] == [
        "time step 1 ms", "time step 0.5 ms", "integrator RK4",
    ]  # fmt: skip
    assert max(one["flight_mm"] for one in variants) < 0.01
    assert variants[-1]["bounce_mm"] == 0.0
