"""The optional parts of the installation, and which of them a missing package belongs to."""

import re
from importlib.metadata import requires
from importlib.util import find_spec

PROJECT = "rallygap"
# Distributions whose package has another name.
PACKAGES = {"scikit-learn": "sklearn", "pyzmq": "zmq"}


def missing_extra(package: str) -> str | None:
    """Return the extra of rallygap that brings a package; None if none does.

    Args:
        package: top-level name that could not be imported, such as ``torch``.
    """
    for requirement in requires(PROJECT) or []:
        extra = re.search(r"extra == ['\"]([\w-]+)['\"]", requirement)
        distribution = re.match(r"[\w.-]+", requirement)
        if extra and distribution:
            name = distribution[0].lower()
            if package == PACKAGES.get(name, name.replace("-", "_")):
                return extra[1]
    return None


def require(package: str) -> None:
    """Check that a package is installed which another process is going to run.

    Raises:
        ModuleNotFoundError: it is not.
    """
    if find_spec(package) is None:
        raise ModuleNotFoundError(f"No module named {package!r}", name=package)
