"""What all tests share."""

import os
from pathlib import Path

import pytest

pytest_plugins = ["tests.services"]


@pytest.fixture(scope="session")
def real_data() -> Path:
    """The folder with the measured sets; tests that ask for it skip where it is not configured."""
    folder = os.environ.get("RALLYGAP_DATA", "")
    if not folder or not Path(folder).is_dir():
        pytest.skip("RALLYGAP_DATA is not a folder with the measured sets")
    return Path(folder)
