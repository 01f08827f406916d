"""Audits of scenes are kept: by content, and never in the way of a new one."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco")

from rallygap.pipeline.engines import audited as module
from rallygap.pipeline.engines.audited import cached_audit
from rallygap.pipeline.engines.load import load_engine
from rallygap.pipeline.io.artifacts import write_text
from tests.models.engines.mujoco.scenes import BALL, CONTACT, SHELL, TABLE, air, ball, written

WORLD = TABLE + ball(f"{BALL} {SHELL} {CONTACT} {air(drag=0.47, lift=0.12)}")
OPTION = 'timestep=".001" integrator="RK4" density="1.2"'
DIGEST = """
import hashlib, sys
from rallygap.pipeline.engines.load import load_scene
print(hashlib.sha256(load_scene(sys.argv[1]).content).hexdigest())
"""


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """The folder of the entries; audits of this file are counted in ``made``."""
    monkeypatch.setattr(module.platformdirs, "user_cache_path", lambda name: tmp_path / "cache")
    return tmp_path / "cache" / "audits"


@pytest.fixture
def made(monkeypatch):
    made, audit = [], module.audited

    def counted(engine, *more):
        made.append(engine.name)
        return audit(engine, *more)

    monkeypatch.setattr(module, "audited", counted)
    return made


@pytest.fixture
def scene(tmp_path):
    """A scene that includes a file, which has its options."""
    write_text(tmp_path / "option.xml", f"<mujoco><option {OPTION}/></mujoco>")
    write_text(
        tmp_path / "scene.xml", written(WORLD).replace("<option />", '<include file="option.xml"/>')
    )
    return str(tmp_path / "scene.xml")


def same(one, other):
    states = [(found.flown["flight"].states, found.flown["table"].states) for found in (one, other)]
    assert one.simulator == other.simulator and repr(one.effects) == repr(other.effects)
    for first, second in zip(*states, strict=True):
        np.testing.assert_array_equal(first, second)


def test_a_scene_is_audited_once_until_it_changes(scene, cache, made):
    shares = []
    first = cached_audit(load_engine(scene))
    second = cached_audit(load_engine(scene), shares.append)
    same(first, second)
    assert made == ["scene"] and shares == [1.0]
    assert [path.suffix for path in cache.iterdir()] == [".pickle"]
    write_text(
        Path(scene).parent / "option.xml", f'<mujoco><option {OPTION} wind="1 0 0"/></mujoco>'
    )
    third = cached_audit(load_engine(scene))
    assert made == ["scene", "scene"] and third.simulator != first.simulator


@pytest.mark.parametrize("content", [b"", b"not a pickle", b"\x80\x05N."])
def test_a_broken_entry_is_replaced(scene, cache, made, content):
    first = cached_audit(load_engine(scene))
    (path,) = cache.iterdir()
    kept = path.read_bytes()
    path.write_bytes(content)
    same(cached_audit(load_engine(scene)), first)
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


def test_an_engine_that_is_no_scene_is_not_kept(cache, made):
    cached_audit(load_engine("literature"))
    assert made == ["literature"] and not cache.exists()


def test_a_scene_has_the_same_content_in_another_process(scene):
    command = [sys.executable, "-c", DIGEST, scene]
    digests = {subprocess.run(command, capture_output=True, check=True).stdout for _ in range(2)}
    assert len(digests) == 1
