"""The report page in headless Chromium: quiet, offline, readable, and its 3-D view alive."""

import json
import re
import time
from pathlib import Path

import pytest
from selenium.webdriver import ActionChains
from selenium.webdriver.common.actions.action_builder import ActionBuilder
from selenium.webdriver.common.actions.interaction import POINTER_TOUCH
from selenium.webdriver.common.actions.pointer_input import PointerInput
from selenium.webdriver.support.select import Select
from selenium.webdriver.support.wait import WebDriverWait

from rallygap.pipeline.web.figure_style import predictor_colour
from tests.pipeline.report.example_reports import OFFSETS

pytestmark = pytest.mark.browser

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "reports" / "index.html"  # of the last run, if there was one
LIGHT, WHOLE = 1.5e6, 16e6  # bytes for a phone: all 3-D views, and the page with its pictures
DESKTOP, PHONE = (1280, 900), (390, 844)
LIGHT_TABLE = "#dbe6ee"
PAPER = (718, 1047)  # A4 without its margins, CSS pixels
COLOURS_DRAWN = """
const canvas = document.getElementById(`${arguments[0]}-view`);
const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
const drawn = new Set();
for (let i = 0; i < pixels.length; i += 4) {
  const hex = [0, 1, 2].map((k) => pixels[i + k].toString(16).padStart(2, "0")).join("");
  if (pixels[i + 3] === 255) drawn.add("#" + hex);
}
return [...drawn];
"""
CUT_OFF = """
return [...document.querySelectorAll(".box, main, body")].filter((box) =>
  box.scrollWidth > box.clientWidth || box.getBoundingClientRect().right > innerWidth
  || getComputedStyle(box).maxHeight !== "none").map((box) => box.outerHTML.slice(0, 200));
"""


def open_page(browser, page_file, size, theme="light"):
    """Open the page of a file."""
    open_address(browser, page_file.as_uri(), size, theme)


def open_address(browser, address, size, theme="light"):
    """Open a page at a size (CSS pixels) and forget what the browser logged before."""
    screen = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": size == PHONE}
    scheme = {"name": "prefers-color-scheme", "value": theme}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [scheme]})
    browser.get("about:blank")
    browser.get_log("browser")
    browser.get_log("performance")
    browser.get(address)


def open_on_paper(browser, page_file):
    """Open the page in dark colours, as a printer then takes it."""
    open_page(browser, page_file, PAPER, "dark")
    dark = {"name": "prefers-color-scheme", "value": "dark"}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print", "features": [dark]})


def displayed(page, selector):
    """Whether each element that a selector finds, of which there are some, can be seen."""
    found = page.find_elements("css selector", selector)
    assert found, selector
    return [one.is_displayed() for one in found]


@pytest.fixture
def page(browser, page_file):
    """The page on a desktop, in light colours."""
    open_page(browser, page_file, DESKTOP)
    return browser


def element(page, identifier):
    return page.find_element("id", identifier)


def picture(page, view="shot"):
    script = "return document.getElementById(`${arguments[0]}-view`).toDataURL()"
    return page.execute_script(script, view)


def requests(page):
    """The addresses that the page has asked for, data URIs apart."""
    messages = [json.loads(entry["message"])["message"] for entry in page.get_log("performance")]
    sent = [m["params"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    return [s["request"]["url"] for s in sent if not s["request"]["url"].startswith("data:")]


def readouts(page, view="shot"):
    outputs = page.find_elements("css selector", f"#{view}-legend output")
    return {output.get_attribute("name"): output.text for output in outputs}


def play_and_check_quiet(page, file):
    """Play every view: the page logs nothing and asks for nothing."""
    for button in page.find_elements("css selector", "button[id$='-play']"):
        button.click()
    time.sleep(0.3)
    assert page.get_log("browser") == []
    assert requests(page) == [file.as_uri()]


@pytest.mark.parametrize("size", [DESKTOP, PHONE], ids=["desktop", "phone"])
def test_the_page_is_quiet_and_only_boxes_of_tables_and_figures_scroll_sideways(
    browser, page_file, size
):
    open_page(browser, page_file, size)
    play_and_check_quiet(browser, page_file)
    script = "return [document.documentElement.scrollWidth, window.innerWidth]"
    page_width, window_width = browser.execute_script(script)
    box = browser.find_element("css selector", "#ingest .box")
    assert page_width <= window_width == size[0]
    assert int(box.get_property("scrollWidth")) > int(box.get_property("clientWidth"))


@pytest.mark.skipif(not PAGE.exists(), reason="needs a run: make reproduce")
def test_the_page_of_the_last_run_is_quiet_offline_whole_and_light(browser):
    text = PAGE.read_text(encoding="utf-8")
    views = re.findall(r'<script type="application/json"[^>]*>(.*?)</script>', text, re.DOTALL)
    assert 0 < sum(len(view.encode()) for view in views) < LIGHT
    assert len(text.encode()) < WHOLE
    open_page(browser, PAGE, PHONE)
    play_and_check_quiet(browser, PAGE)
    widths = "return [...document.images].map((image) => image.naturalWidth)"
    assert min(browser.execute_script(widths)) > 0
    open_on_paper(browser, PAGE)
    assert browser.execute_script(CUT_OFF) == []


def test_dark_theme_is_dark_and_paper_white_whole_and_says_what_the_views_show(browser, page_file):
    drawn = "return getComputedStyle(document.body)[arguments[0]]"
    for theme, colour in (("light", "rgb(251, 251, 250)"), ("dark", "rgb(21, 25, 29)")):
        open_page(browser, page_file, DESKTOP, theme)
        assert browser.execute_script(drawn, "backgroundColor") == colour
    open_on_paper(browser, page_file)
    assert browser.execute_script(drawn, "backgroundColor") == "rgba(0, 0, 0, 0)"
    assert browser.execute_script(drawn, "color") == "rgb(32, 38, 45)"
    for useless in ("nav", ".hint", "button", "input", ".speed", ".animation .moving"):
        assert not any(displayed(browser, useless)), useless
    parts = ("article", "h1, h2, h3", ".caption, figcaption", ".run:not(.hint)", ".still")
    for shown in (*parts, "canvas", ".viewer .clock", ".legend output", "select[id$='-picker']"):
        assert all(displayed(browser, shown)), shown
    assert browser.execute_script(CUT_OFF) == []
    WebDriverWait(browser, 10).until(
        lambda page: LIGHT_TABLE in page.execute_script(COLOURS_DRAWN, "shot")
    )


def test_animation_moves_until_it_is_stopped(page):
    moving, still, box = page.find_elements("css selector", ".animation img, .animation input")
    before = moving.screenshot_as_png
    WebDriverWait(page, 10).until(lambda _: moving.screenshot_as_png != before)
    box.click()
    assert still.is_displayed() and not moving.is_displayed()


def test_play_moves_time_on_and_pause_stops_it(page):
    slider, button = element(page, "shot-time"), element(page, "shot-play")
    start, before = int(slider.get_property("value")), picture(page)
    Select(element(page, "shot-speed")).select_by_visible_text("1/20")
    button.click()
    WebDriverWait(page, 10).until(lambda _: int(slider.get_property("value")) >= start + 20)
    button.click()
    stopped = slider.get_property("value")
    time.sleep(0.2)
    assert slider.get_property("value") == stopped
    assert button.text == "Play"
    assert picture(page) != before


def test_mouse_and_finger_turn_the_view_and_double_click_returns(browser, page_file):
    open_page(browser, page_file, DESKTOP)
    view, before = element(browser, "shot-view"), picture(browser)
    ActionChains(browser).drag_and_drop_by_offset(view, 120, 30).perform()
    assert picture(browser) != before
    ActionChains(browser).double_click(view).perform()
    assert picture(browser) == before
    open_page(browser, page_file, PHONE)
    view, before = element(browser, "shot-view"), picture(browser)
    actions = ActionBuilder(browser, mouse=PointerInput(POINTER_TOUCH, "finger"))
    actions.pointer_action.move_to(view).pointer_down().move_to(view, 80, 40).pointer_up()
    actions.perform()
    assert picture(browser) != before


def test_views_draw_the_table_and_every_forecast_and_returns_the_arm_and_its_racket(page):
    arm, racket = "#7a8793", "#b8431a"
    shots, returns = (set(page.execute_script(COLOURS_DRAWN, view)) for view in ("shot", "return"))
    forecasts = set(map(predictor_colour, OFFSETS))
    assert {LIGHT_TABLE, *forecasts} <= shots and not {arm, racket} & shots
    assert {arm, *forecasts} <= returns


def test_forecasts_are_judged_by_their_distance_from_the_ball(page):
    """Those of returns at the policy's horizon, until the racket meets the ball."""
    errors = {"physics_c": "50 mm", "physics_literature": "80 mm"}
    assert element(page, "shot-clock").text == "+300 ms"
    assert readouts(page) == errors
    assert element(page, "return-clock").text == "−120 ms"
    assert readouts(page, "return") == errors
    script = "arguments[0].value = -100; arguments[0].dispatchEvent(new Event('input'))"
    page.execute_script(script, element(page, "return-time"))
    assert readouts(page, "return") == dict.fromkeys(errors, "–")
