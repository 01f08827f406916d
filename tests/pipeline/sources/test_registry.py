"""Finding sources: the shipped ones and those of other packages."""

import pkgutil
from types import SimpleNamespace

import pytest

from rallygap.models.support import discovery
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources import adapters, registry
from rallygap.pipeline.sources.registry import find_source


def test_every_adapter_is_found_under_the_name_of_its_file():
    files = {module.name for module in pkgutil.iter_modules(adapters.__path__)}
    assert {name: find_source(name).name for name in files} == {name: name for name in files}


def test_another_package_can_offer_a_source_under_a_new_name(monkeypatch):
    def known_with(name):
        module = SimpleNamespace(source=SimpleNamespace(name=name))
        offers = {"rallygap.sources": [SimpleNamespace(name=name, load=lambda: module)]}
        monkeypatch.setattr(discovery, "entry_points", lambda group: offers[group])
        return registry.registry.__wrapped__()

    assert "my_lab" in known_with("my_lab")
    with pytest.raises(ValueError, match="two sources are called tt3d"):
        known_with("tt3d")


def test_an_unknown_source_names_the_known_ones():
    with pytest.raises(InputError, match=r"ingest\.sources: there is no source 'tt3e'.*tt3d"):
        find_source("tt3e")
