"""Finding sources: the shipped ones and those of other packages."""

import pkgutil
from importlib.metadata import EntryPoint
from types import SimpleNamespace

import pytest

from rallygap.models.support import discovery
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources import adapters, registry
from rallygap.pipeline.sources.registry import find_source


@pytest.fixture
def offered(monkeypatch):
    """Makes other packages offer sources for the time of a test."""

    def offer(*names):
        modules = {name: SimpleNamespace(source=SimpleNamespace(name=name)) for name in names}
        points = [EntryPoint(name, name, registry.ENTRY_POINT_GROUP) for name in names]
        monkeypatch.setattr(EntryPoint, "load", lambda point: modules[point.value])
        monkeypatch.setattr(discovery, "entry_points", lambda group: points)
        registry.registry.cache_clear()

    yield offer
    registry.registry.cache_clear()


def test_every_adapter_is_found_under_the_name_of_its_file():
    files = {module.name for module in pkgutil.iter_modules(adapters.__path__)}
    assert {name: find_source(name).name for name in files} == {name: name for name in files}


def test_a_package_can_offer_a_source(offered):
    offered("my_lab")
    assert find_source("my_lab").name == "my_lab"


def test_a_name_can_be_taken_once(offered):
    offered("tt3d")
    with pytest.raises(ValueError, match="two sources are called tt3d"):
        registry.registry()


def test_an_unknown_source_names_the_known_ones():
    with pytest.raises(InputError, match=r"ingest\.sources: there is no source 'tt3e'.*tt3d"):
        find_source("tt3e")
