"""The known sources: every file of ``adapters/``, then those of other packages.

A package adds its own by the entry point group ``rallygap.sources``; each entry point is a module
with a ``source``, like the modules of ``adapters``.
"""

from functools import cache

from rallygap.models.support.discovery import discovered
from rallygap.models.support.suggestion import suggestion
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources import adapters
from rallygap.pipeline.sources.source import Source

ENTRY_POINT_GROUP = "rallygap.sources"


@cache
def registry() -> dict[str, Source]:
    """Return every known source by name.

    Raises:
        ValueError: two sources share a name.
    """
    sources: dict[str, Source] = {}
    for source in discovered(adapters, "source", ENTRY_POINT_GROUP):
        if source.name in sources:
            raise ValueError(f"two sources are called {source.name}")
        sources[source.name] = source
    return sources


def find_source(name: str) -> Source:
    """Return the source called ``name``.

    Raises:
        InputError: there is none of that name.
    """
    if name not in registry():
        problem = f"there is no source {name!r}; {suggestion(name, registry())}"
        raise InputError("params.yaml", problem, field="ingest.sources")
    return registry()[name]
