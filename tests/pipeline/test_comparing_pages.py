"""What two runs look like next to each other in MLflow: the pictures of docs/daily.md.

``make pictures`` writes them.
"""

import json
import time
from urllib.parse import quote

import pytest
from selenium.webdriver.support.wait import WebDriverWait

from tests.pipeline.example_experiments import CHANGED
from tests.pipeline.runs import runs, served_pages
from tests.services import PATIENCE

pytestmark = [pytest.mark.slow, pytest.mark.browser]

SIZE = {"width": 1280, "height": 860, "deviceScaleFactor": 1, "mobile": False}
LEFT = "document.querySelectorAll('*').forEach(one => { one.scrollLeft = 0; })"
FOLDED = "//*[@role='button'][.='Visualizations' or .='Run details']"


@pytest.fixture(scope="module")
def server(experiments):
    with served_pages(experiments, experiments) as (address, _):
        yield address


@pytest.fixture(scope="module")
def parents(experiments):
    """The runs of the experiments `base` and `strict`."""
    query = "tags.`mlflow.source.name` = 'dvc' AND attributes.status = 'FINISHED'"
    found = runs(experiments, query, order_by=["start_time ASC"], max_results=2)
    return [one.info for one in found]


@pytest.fixture
def window(browser):
    """A browser of the pictures' size, without MLflow's assistant."""
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", SIZE)
    closed = "localStorage.setItem('mlflow.assistant.fab.autoOpenedOnFirstLoad_v1', 'true');"
    done = browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": closed})
    yield browser
    browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", done)


def shown(window, url, text):
    """Open a page of MLflow's and wait until it shows a text."""
    window.get(url)
    WebDriverWait(window, PATIENCE).until(
        lambda one: text in one.find_element("tag name", "body").text
    )


def photographed(window, path):
    time.sleep(2)  # until what moves on the page stands still
    assert window.save_screenshot(str(path))


def test_the_list_of_runs_has_the_experiments(window, server, parents, pictures):
    shown(window, f"{server}/#/experiments/{parents[0].experiment_id}/runs", "strict")
    photographed(window, pictures / "mlflow_runs.png")


def test_two_experiments_show_what_changed_and_what_it_did(window, server, parents, pictures):
    ids = quote(json.dumps([one.run_id for one in parents]))
    experiments = quote(json.dumps([parents[0].experiment_id]))
    url = f"{server}/#/compare-runs?runs={ids}&experiments={experiments}"
    shown(window, url, "Comparing 2 Runs")
    for heading in window.find_elements("xpath", FOLDED):
        heading.click()
    text = " ".join(window.find_element("tag name", "body").text.split())
    for metric in ("ingest/arena/recordings", "score_segmentation/table/recall"):
        assert metric in text
    toggle = window.find_element("css selector", "[aria-label='Metrics - Show diff only']")
    window.execute_script("arguments[0].click()", toggle)
    window.execute_script(LEFT)
    photographed(window, pictures / "mlflow_compare.png")
    assert f"{CHANGED} 4.0" in text
    assert "segment/arena/episodes" in window.find_element("tag name", "body").text
