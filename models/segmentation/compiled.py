"""The decorator of this package's compiled functions."""

from pathlib import Path

from rallygap.models.ball import state
from rallygap.models.support.compilation import compiler

compiled = compiler([*sorted(Path(__file__).parent.glob("*.py")), Path(state.__file__)])
