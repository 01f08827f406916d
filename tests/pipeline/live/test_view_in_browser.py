"""The view in headless Chromium: it draws what it is fed, says it in numbers, and is quiet."""

import pytest
from selenium.webdriver.support.wait import WebDriverWait

from rallygap.pipeline.live.latency import Latencies
from rallygap.pipeline.live.view import served
from tests.pipeline.live.example_frames import ALARM, frames, rows
from tests.pipeline.report.test_page_in_browser import (
    COLOURS_DRAWN,
    DESKTOP,
    PHONE,
    element,
    open_address,
    picture,
    requests,
)
from tests.services import free_port

pytestmark = pytest.mark.browser

TABLE, FORECAST, BOUNCE = "#dbe6ee", "#0b62a0", "#00786c"


@pytest.fixture
def server():
    latencies = Latencies()
    for milliseconds in (0.4, 0.5, 0.9):
        latencies.add(milliseconds / 1e3)
    with served(free_port(), latencies) as server:
        yield server


@pytest.fixture
def page(browser, server):
    """The view on a desktop, in light colours; blank afterwards, so that it asks for nothing."""
    open_address(browser, server.address, DESKTOP)
    yield browser
    browser.get("about:blank")


def show(page, server, frame):
    """Show a frame, and wait until the page has it."""
    server.show(frame)
    number = frame.message.split('"num": ')[1].split(",")[0]
    WebDriverWait(page, 10).until(lambda _: text(page, "frame").startswith(f"{number}:"))


def text(page, identifier):
    return element(page, identifier).text


def test_forecasts_are_drawn_as_they_come_and_said_in_numbers(page, server):
    WebDriverWait(page, 10).until(lambda _: text(page, "state").startswith("Connected"))
    drawn = set(page.execute_script(COLOURS_DRAWN, "live"))
    assert TABLE in drawn
    assert not {FORECAST, BOUNCE} & drawn
    assert text(page, "frame") == "–"
    pictures, shown = set(), frames(rows(30))
    for frame in (shown[6], shown[9], shown[12]):
        show(page, server, frame)
        pictures.add(picture(page, "live"))
    assert len(pictures) == 3
    assert {TABLE, FORECAST, BOUNCE} <= set(page.execute_script(COLOURS_DRAWN, "live"))
    frame = shown[29]
    show(page, server, frame)
    bounce = frame.ball.bounce
    assert text(page, "state") == "A ball is measured."
    assert text(page, "frame") == "29: used"
    assert text(page, "bounce").startswith(f"in {1e3 * (bounce.time - frame.ball.time):.0f} ms")
    assert f"standard error {1e3 * bounce.time_error:.1f} ms" in text(page, "bounce")
    assert "mm in 100 ms" in text(page, "error") and "mm in 300 ms" in text(page, "error")
    assert text(page, "latency") == "0.51 ms (p50), 0.91 ms (p99) of 3 frames"
    assert not element(page, "alarm").is_displayed()
    before = picture(page, "live")
    element(page, "live-view").send_keys("+")  # keys turn the view
    assert picture(page, "live") != before


def test_a_ball_that_is_gone_is_not_drawn_and_an_alarm_is_said(page, server):
    seen, *_, gone = frames(rows(40, lost=[0.3, 0.9]), ALARM)[-3:]
    show(page, server, seen)
    assert FORECAST in page.execute_script(COLOURS_DRAWN, "live")
    show(page, server, gone)
    assert FORECAST not in page.execute_script(COLOURS_DRAWN, "live")
    assert text(page, "frame") == "41: unused"
    assert (text(page, "state"), text(page, "bounce")) == ("No ball.", "–")
    assert "wind.x (the air moves) has changed by +0.31 m/s" in text(page, "alarm")
    assert element(page, "alarm").is_displayed()


@pytest.mark.parametrize("size", [DESKTOP, PHONE], ids=["desktop", "phone"])
def test_no_console_message_and_no_request_to_another_host(browser, server, size):
    open_address(browser, server.address, size)
    for frame in frames(rows(12)):
        show(browser, server, frame)
    script = "return [document.documentElement.scrollWidth, window.innerWidth]"
    page_width, window_width = browser.execute_script(script)

    assert browser.get_log("browser") == []
    assert requests(browser) == [server.address, f"{server.address}events"]
    assert page_width <= window_width
    browser.get("about:blank")


def test_the_end_is_said_and_a_new_start_is_found(browser):
    port = free_port()
    with served(port, Latencies()) as first:
        open_address(browser, first.address, DESKTOP)
        WebDriverWait(browser, 10).until(lambda page: "Connected" in text(page, "state"))
    WebDriverWait(browser, 10).until(lambda page: "Not connected" in text(page, "state"))
    with served(port, Latencies()):
        WebDriverWait(browser, 20).until(lambda page: "Connected" in text(page, "state"))
        browser.get("about:blank")
