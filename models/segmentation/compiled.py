"""The decorator of this package's compiled functions."""

from pathlib import Path

from models.ball import state
from models.support.compilation import compiler

compiled = compiler([*sorted(Path(__file__).parent.glob("*.py")), Path(state.__file__)])
