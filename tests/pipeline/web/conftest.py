"""A made-up reports folder, and its page."""

from pathlib import Path

import pytest

from rallygap.pipeline.io.figure_style import apply_style
from tests.pipeline.web.example_reports import made_up_page, make_reports


@pytest.fixture(scope="session")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the reports and artefacts of every stage before the report."""
    apply_style()
    root = tmp_path_factory.mktemp("root")
    make_reports(root)
    return root


@pytest.fixture(scope="session")
def page_file(root: Path) -> Path:
    """The report page of ``root``."""
    path = root / "reports" / "index.html"
    path.write_text(made_up_page(root), encoding="utf-8")
    return path
