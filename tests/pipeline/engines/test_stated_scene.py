"""Audits of scenes: what the file says next to what the scene does."""

import json

import pytest

pytest.importorskip("mujoco")

from rallygap.models.engines.mujoco.scene import MujocoScene
from rallygap.pipeline.engines.audit_folder import audit_folder
from rallygap.pipeline.engines.audited import audited
from rallygap.pipeline.engines.comparison import StatedScene
from tests.models.engines.mujoco.scenes import (
    BALL,
    CONTACT,
    SHELL,
    TABLE,
    air,
    ball,
    compiled,
    written,
)

OPTION = 'timestep=".0005" integrator="RK4" density="1.2"'
WORLD = TABLE + ball(f"{BALL} {SHELL} {CONTACT} {air(drag=0.47, lift=0.12)}")
COEFFICIENTS = 'fluidshape="ellipsoid" fluidcoef=".47 0 0 0 .069"'  # as one would read them
NATURAL = TABLE + ball(f"{BALL} {SHELL} {CONTACT} {COEFFICIENTS}")


def test_a_scene_does_what_it_says():
    scene = MujocoScene.of("scene", compiled(WORLD, OPTION))
    audit = audited(scene)
    table = StatedScene.of(scene, audit).table()
    rows = {name: cells for name, *cells in zip(*table.values(), strict=True)}
    assert rows["drag.cd"] == ["0.47", "0.47"]
    assert rows["magnus.cm"] == ["0.12", "0.12"]
    says, does = (float(one) for one in rows["table_bounce.restitution"])
    assert does == pytest.approx(says, abs=0.02)


def test_flights_do_not_change_with_a_shorter_step_and_contacts_may():
    scene = MujocoScene.of("scene", compiled(WORLD, OPTION))
    variants = StatedScene.of(scene, audited(scene)).variants
    assert [one.name for one in variants] == [
        "time step 0.25 ms", "time step 0.125 ms", "integrator RK4",
    ]  # fmt: skip
    assert max(one.flight_mm for one in variants) < 0.01
    assert variants[-1].bounce_mm == 0.0


def test_the_natural_reading_of_a_scene_is_named_with_its_cost(tmp_path):
    (tmp_path / "scene.xml").write_text(written(NATURAL, OPTION))
    said = audit_folder(str(tmp_path / "scene.xml"), tmp_path / "out")
    assert any(line.startswith("Trap: Lift is inverse (C_M -0.431)") for line in said)
    assert any(line.startswith("Note: C_D is 0.94") for line in said)
    content = json.loads((tmp_path / "out" / "audit.json").read_text())
    assert content["says"]["drag"]["cd"] == pytest.approx(0.94)
    assert len(content["variants"]) == 3
    page = (tmp_path / "out" / "report.html").read_text()
    assert "What the file says" in page and "the scene does" in page
