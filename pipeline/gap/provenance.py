"""What a verdict was made from: data, simulator, settings and version, for its file."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.settings import DEFAULTS, GapSettings
from rallygap.models.gap.verdict import MadeFrom


def made_from(
    data: str,
    folder: str | None,
    counts: tuple[int, int],
    simulator: Simulator,
    simulator_name: str,
    settings: GapSettings,
) -> MadeFrom:
    """Return what a verdict was made from; of a simulator's path only the file's name is kept.

    Args:
        data: name of the source.
        folder: name of the folder of the recordings, if there is one.
        counts: of recordings and of shots.
        simulator: the nominal one.
        simulator_name: a shipped one's name, or a path.
        settings: of the workflow.
    """
    recordings, shots = counts
    return MadeFrom(
        data=data,
        folder=folder,
        recordings=recordings,
        shots=shots,
        simulator=Path(simulator_name).name,
        effects=simulator.to_dict(),
        settings=changed_settings(settings),
        version=version("rallygap"),
    )


def changed_settings(settings: GapSettings) -> dict[str, Any]:
    """Return the level, and other settings that are not the default (``fit.refit_steps``)."""
    default = _by_name(DEFAULTS)
    changed = {name: one for name, one in _by_name(settings).items() if one != default[name]}
    return {"level": settings.level, **changed}


def _by_name(settings: Any, prefix: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for field in fields(settings):
        name, value = f"{prefix}{field.name}", getattr(settings, field.name)
        if is_dataclass(value):
            found |= _by_name(value, f"{name}.")
        else:
            found[name] = dict(value) if isinstance(value, Mapping) else value
    return found
