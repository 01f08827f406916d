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
    """Return what a verdict was made from.

    Args:
        data: name of the source.
        folder: name of the folder of the recordings, if there is one.
        counts: of recordings and of shots.
        simulator: the nominal one.
        simulator_name: a shipped one's name, or a path, of which only the file's name is kept.
        settings: of the workflow: the level is kept, and others that are not the default, such as
            ``fit.refit_steps``.
    """
    recordings, shots = counts
    default = _by_name(DEFAULTS)
    changed = {name: value for name, value in _by_name(settings).items() if value != default[name]}
    return MadeFrom(
        data=data,
        folder=folder,
        recordings=recordings,
        shots=shots,
        simulator=Path(simulator_name).name,
        effects=simulator.to_dict(),
        settings={"level": settings.level, **changed},
        version=version("rallygap"),
    )


def _by_name(settings: Any, prefix: str = "") -> dict[str, Any]:
    """Return the values of settings by their dotted names."""
    values: dict[str, Any] = {}
    for field in fields(settings):
        name, value = f"{prefix}{field.name}", getattr(settings, field.name)
        if is_dataclass(value):
            values |= _by_name(value, f"{name}.")
        else:
            values[name] = dict(value) if isinstance(value, Mapping) else value
    return values
