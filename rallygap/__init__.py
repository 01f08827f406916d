"""Find where a ball simulator and measured trajectories disagree, and name the missing effect.

The public names are documented in docs/python-api.md. Each is imported when it is first used:
``import rallygap`` loads no library and changes nothing in the process.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rallygap.models.ball.simulator import Simulator
    from rallygap.models.gap.amend.simulator import amended
    from rallygap.models.gap.diagnose import diagnose
    from rallygap.models.gap.fit.shots import Shots
    from rallygap.models.gap.verdict import Verdict
    from rallygap.models.live.forecaster import Forecaster
    from rallygap.pipeline.api import audit, load_simulator
    from rallygap.pipeline.gap.measured_shots import read_shots

__all__ = [
    "Forecaster",
    "Shots",
    "Simulator",
    "Verdict",
    "amended",
    "audit",
    "diagnose",
    "load_simulator",
    "read_shots",
]

_MODULES = {
    "Forecaster": "models.live.forecaster",
    "Shots": "models.gap.fit.shots",
    "Simulator": "models.ball.simulator",
    "Verdict": "models.gap.verdict",
    "amended": "models.gap.amend.simulator",
    "audit": "pipeline.api",
    "diagnose": "models.gap.diagnose",
    "load_simulator": "pipeline.api",
    "read_shots": "pipeline.gap.measured_shots",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'rallygap' has no attribute {name!r}")
    value = getattr(import_module(f"rallygap.{_MODULES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
