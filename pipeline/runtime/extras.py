"""The optional parts of the installation, and which of them a missing package belongs to."""

import re
from collections.abc import Iterator
from importlib.metadata import requires
from importlib.util import find_spec

PROJECT = "rallygap"
# Distributions whose package has another name.
PACKAGES = {"scikit-learn": "sklearn", "psycopg": "psycopg", "pyzmq": "zmq"}


def missing_extra(package: str) -> str | None:
    """Return the extra of rallygap that brings a package; None if none does.

    Args:
        package: top-level name that could not be imported, such as ``torch``.
    """
    return next((extra for extra, name in _packages_of_extras() if name == package), None)


def _packages_of_extras() -> Iterator[tuple[str, str]]:
    for requirement in requires(PROJECT) or []:
        extra = re.search(r"extra == ['\"]([\w-]+)['\"]", requirement)
        distribution = re.match(r"[\w.-]+", requirement)
        if extra and distribution:
            name = distribution[0].lower()
            yield extra[1], PACKAGES.get(name, name.replace("-", "_"))


def require(package: str) -> None:
    """Check that a package is installed which another process is going to run.

    Raises:
        ModuleNotFoundError: it is not.
    """
    if find_spec(package) is None:
        raise ModuleNotFoundError(f"No module named {package!r}", name=package)
