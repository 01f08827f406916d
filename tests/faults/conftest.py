"""What all tests of kills and faults share."""

import pytest

from tests.faults.repository import Repository, undisturbed


@pytest.fixture(scope="session")
def repository(tmp_path_factory: pytest.TempPathFactory) -> Repository:
    """A copy of the repository that has run undisturbed."""
    return undisturbed(tmp_path_factory.mktemp("faults"))
