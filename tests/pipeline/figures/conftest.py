"""A made-up reports folder, and a headless browser to look at its page."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

from pipeline.figures.style import apply_style
from tests.pipeline.figures.made_up import made_up_page, make_reports

FLAGS = [
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]


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


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[webdriver.Chrome]:
    """Headless Chromium; tests that ask for it skip where it or its driver is absent."""
    driver = shutil.which("chromedriver")
    if driver is None or shutil.which("chromium") is None:
        pytest.skip("Chromium and chromedriver are not installed")
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for flag in [*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('chromium')}"]:
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("SE_AVOID_STATS", "true")
        browser = webdriver.Chrome(options=options, service=Service(driver))
    yield browser
    browser.quit()
