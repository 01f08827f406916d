"""What all tests share."""

import os
from pathlib import Path

import hypothesis
import pytest

# The same examples in every run, and no limit that a busy machine exceeds.
hypothesis.settings.register_profile("rallygap", derandomize=True, deadline=None)
hypothesis.settings.load_profile("rallygap")

pytest_plugins = ["tests.browser", "tests.pipeline.example_experiments", "tests.services"]


@pytest.fixture(scope="session")
def real_data() -> Path:
    """The folder with the measured sets; tests that ask for it skip where it is not configured."""
    folder = os.environ.get("RALLYGAP_DATA", "")
    if not folder or not Path(folder).is_dir():
        pytest.skip("RALLYGAP_DATA is not a folder with the measured sets")
    return Path(folder)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Let `make pictures` keep what tests photograph."""
    parser.addoption("--pictures", metavar="FOLDER", help="where pictures of pages are kept")


@pytest.fixture(scope="session")
def pictures(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where tests leave pictures of pages."""
    kept = request.config.getoption("--pictures")
    folder = Path(kept) if kept else tmp_path_factory.mktemp("pictures")
    folder.mkdir(parents=True, exist_ok=True)
    return folder
