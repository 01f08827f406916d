"""A made-up reports folder, and its page; every figure is in the project's style."""

from pathlib import Path

import pytest

from rallygap.pipeline.web.figure_style import apply_style
from tests.pipeline.report.example_reports import made_up_page, make_reports


@pytest.fixture(autouse=True, scope="session")
def style():
    """Draw as the pipeline does."""
    apply_style()


@pytest.fixture(scope="session")
def page_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report page of made-up reports and artefacts."""
    root = tmp_path_factory.mktemp("root")
    path = root / "reports" / "index.html"
    path.write_text(made_up_page(root, make_reports(root)), encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def page(page_file: Path) -> str:
    """Its text."""
    return page_file.read_text(encoding="utf-8")
