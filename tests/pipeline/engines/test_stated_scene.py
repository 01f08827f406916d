"""Audits of scenes: what the file says next to what the scene does."""

import json

import pytest

pytest.importorskip("mujoco")

from rallygap.pipeline.engines.audit_folder import audit_folder
from tests.models.engines.mujoco.scenes import BALL, CONTACT, SHELL, TABLE, ball, written

# As one would read them, with a contact that is as soft as the time step is long.
COEFFICIENTS = 'fluidshape="ellipsoid" fluidcoef=".47 0 0 0 .069"'
SOFT = CONTACT.replace("-1000000 -47", "-250000 -23")
OPTION = 'timestep=".002" integrator="RK4" density="1.2"'


def test_the_natural_reading_of_a_scene_is_named_with_its_cost_and_variants(tmp_path):
    scene = tmp_path / "scene.xml"
    scene.write_text(written(TABLE + ball(f"{BALL} {SHELL} {SOFT} {COEFFICIENTS}"), OPTION))
    said = audit_folder(str(scene), tmp_path / "out")
    assert any(line.startswith("Trap: Lift is inverse (C_M -0.431)") for line in said)
    assert any(line.startswith("Note: C_D is 0.94") for line in said)
    assert "What the file says" in (tmp_path / "out" / "report.html").read_text()
    content = json.loads((tmp_path / "out" / "audit.json").read_text())
    says, does = content["says"], {one["identity"]: one["value"] for one in content["effects"]}
    assert does["drag.cd"] == pytest.approx(says["drag"]["cd"], abs=1e-3)
    assert does["magnus.cm"] == pytest.approx(says["magnus"]["cm"], abs=1e-3)
    restitution = does["table_bounce.restitution"]
    assert restitution == pytest.approx(says["table_bounce"]["restitution"], abs=0.02)
    variants = {one["name"]: one for one in content["variants"]}
    assert list(variants) == ["time step 1 ms", "time step 0.5 ms", "integrator RK4"]
    assert max(one["flight_mm"] for one in variants.values()) < 0.01
    assert variants["integrator RK4"]["bounce_mm"] == 0.0
