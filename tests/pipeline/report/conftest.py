"""A made-up reports folder, and its page; every figure is in the project's style."""

from pathlib import Path

import pytest

from rallygap.pipeline.web.figure_style import apply_style
from tests.pipeline.report.example_reports import Items, made_up_page, make_reports


@pytest.fixture(autouse=True, scope="session")
def style():
    """Draw as the pipeline does."""
    apply_style()


@pytest.fixture(scope="session")
def made_up(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Items]:
    """A folder with reports and artefacts, and the items of its page."""
    root = tmp_path_factory.mktemp("root")
    return root, make_reports(root)


@pytest.fixture(scope="session")
def page_file(made_up: tuple[Path, Items]) -> Path:
    """The report page of made-up reports and artefacts."""
    root, items = made_up
    path = root / "reports" / "index.html"
    path.write_text(made_up_page(root, items), encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def page(page_file: Path) -> str:
    """Its text."""
    return page_file.read_text(encoding="utf-8")
