"""The decorator of this package's compiled functions."""

from pathlib import Path

from rallygap.models.ball import state
from rallygap.models.support.compilation import compiler

_HERE = Path(__file__).parent
_SOURCES = (_HERE / f"{name}.py" for name in ("constants", "kinematics", "control", "contact"))

compiled = compiler([*_SOURCES, Path(state.__file__)])
