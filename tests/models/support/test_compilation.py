"""Stored binaries: made once, never stale, wherever home and sources are."""

import runpy
from pathlib import Path

import pytest

from rallygap.models.support.compilation import compiler


@pytest.fixture
def source(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    path = tmp_path / "constants.py"
    path.write_text("DRAG = 1.0")
    return path


def folder(*arguments):
    """Where the binaries of a function of these sources are kept."""

    @compiler(*arguments)
    def doubled(x: float) -> float:
        return 2.0 * x

    assert doubled(1.5) == 3.0
    return Path(doubled.stats.cache_path)


def test_a_folder_is_for_the_same_sources_and_what_no_file_says(source):
    first, second = folder([source], "adds"), folder([source], "adds")
    assert first == second
    assert list(first.glob("*.nbc"))
    assert folder([source], "scales") != first
    source.write_text("DRAG = 2.0")
    assert folder([source], "adds") != first


def test_a_home_without_room_for_a_cache_is_left_alone(source, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(source))
    assert tmp_path not in folder([source]).parents


def test_copies_of_a_source_share_their_binaries(source, tmp_path):
    code = "import rallygap.models.support.compilation as c\n@c.compiler([])\ndef f(x): return x"
    for copy, compiled in (("one", 1), ("two", 0)):
        path = tmp_path / copy / "ball" / "flight.py"
        path.parent.mkdir(parents=True)
        path.write_text(code)
        function = runpy.run_path(str(path))["f"]
        assert function(1.5) == 1.5
        assert len(function.stats.cache_misses) == compiled
