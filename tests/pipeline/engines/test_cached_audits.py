"""Audits of scenes: what the file says next to what the scene does; they are kept by content."""

import hashlib
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco")

from rallygap.pipeline.engines import audited as module
from rallygap.pipeline.engines.audit_folder import audit_folder
from rallygap.pipeline.engines.audited import cached_audit
from rallygap.pipeline.engines.load import load_engine
from rallygap.pipeline.io.artifacts import write_text
from tests.models.engines.mujoco.scenes import BALL, CONTACT, SHELL, TABLE, ball, written

OPTION = 'timestep=".001" integrator="RK4" density="1.2"'
OTHER_PROCESS = """
import hashlib, sys
from rallygap.pipeline.engines.load import load_scene
assert "mujoco" not in sys.modules
print(hashlib.sha256(load_scene(sys.argv[1]).content).hexdigest())
"""


@pytest.fixture(scope="module")
def audit():
    return module.audited(load_engine("literature"))


@pytest.fixture
def made(monkeypatch, audit):
    """The names of the engines that are audited, which all have the audit of ``literature``."""
    made = []

    def counted(engine, *more):
        made.append(engine.name)
        return audit

    monkeypatch.setattr(module, "audited", counted)
    return made


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """The folder of the entries."""
    monkeypatch.setattr(module.platformdirs, "user_cache_path", lambda name: tmp_path / "cache")
    return tmp_path / "cache" / "audits"


@pytest.fixture
def scene(tmp_path):
    """A scene that includes a file, which has its options."""
    write_text(tmp_path / "option.xml", f"<mujoco><option {OPTION}/></mujoco>")
    text = written(TABLE + ball(f"{BALL} {SHELL}"))
    write_text(tmp_path / "scene.xml", text.replace("<option />", '<include file="option.xml"/>'))
    return str(tmp_path / "scene.xml")


def check_same(one, other):
    assert one.simulator == other.simulator and repr(one.effects) == repr(other.effects)
    for phase in ("flight", "table"):
        np.testing.assert_array_equal(one.flown[phase].states, other.flown[phase].states)


def test_a_scene_is_audited_once_until_an_included_file_changes(scene, cache, made, audit):
    shares = []
    cached_audit(load_engine(scene))
    check_same(cached_audit(load_engine(scene), shares.append), audit)
    assert made == ["scene"] and shares == [1.0]
    assert [path.suffix for path in cache.iterdir()] == [".pickle"]
    option = f'<mujoco><option {OPTION} wind="1 0 0"/></mujoco>'
    write_text(Path(scene).with_name("option.xml"), option)
    cached_audit(load_engine(scene))
    assert made == ["scene", "scene"] and len(list(cache.iterdir())) == 2


@pytest.mark.parametrize("content", [b"not a pickle", b"\x80\x05N."])
def test_a_broken_entry_is_replaced(scene, cache, made, audit, content):
    cached_audit(load_engine(scene))
    (path,) = cache.iterdir()
    kept = path.read_bytes()
    path.write_bytes(content)
    check_same(cached_audit(load_engine(scene)), audit)
    assert len(made) == 2 and path.read_bytes() == kept


def test_other_code_and_another_version_of_mujoco_audit_again(scene, cache, made, monkeypatch):
    cached_audit(load_engine(scene))
    monkeypatch.setattr(module, "version", lambda name: "0.0")
    cached_audit(load_engine(scene))
    monkeypatch.setattr(module, "__file__", __file__)
    cached_audit(load_engine(scene))
    assert len(made) == len(list(cache.iterdir())) == 3


def test_a_cache_that_cannot_be_written_to_is_no_error(scene, cache, made):
    cache.parent.write_text("a file in the place of the folder")
    for _ in range(2):
        cached_audit(load_engine(scene))
    assert len(made) == 2


def test_a_scene_has_the_same_content_in_another_process_which_loads_mujoco_for_it_alone(scene):
    command = [sys.executable, "-c", OTHER_PROCESS, scene]
    digest = subprocess.run(command, capture_output=True, check=True, text=True, timeout=60).stdout
    assert digest.strip() == hashlib.sha256(load_engine(scene).content).hexdigest()


def test_the_natural_reading_of_a_scene_is_named_with_its_cost_and_variants(tmp_path):
    coefficients = 'fluidshape="ellipsoid" fluidcoef=".47 0 0 0 .069"'
    soft = CONTACT.replace("-1000000 -47", "-250000 -23")  # as the time step is long
    text = written(TABLE + ball(f"{BALL} {SHELL} {soft} {coefficients}"), OPTION)
    write_text(tmp_path / "scene.xml", text.replace('".001" int', '".002" int'))
    said = audit_folder(str(tmp_path / "scene.xml"), tmp_path / "out")
    assert any(line.startswith("Trap: Lift is inverse (C_M -0.431)") for line in said)
    assert any(line.startswith("Note: C_D is 0.94") for line in said)
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
