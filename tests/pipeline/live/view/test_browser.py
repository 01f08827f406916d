"""The view is opened where there is a screen, and nothing is started where there is none."""

import threading
import webbrowser

import pytest

from rallygap.pipeline.live.view import server as browser
from rallygap.pipeline.live.view.server import open_browser

ADDRESS = "http://127.0.0.1:7662/"


@pytest.fixture
def opened(monkeypatch):
    """Addresses that were opened, on Linux without a screen."""
    addresses = []
    monkeypatch.setattr(browser.sys, "platform", "linux")
    monkeypatch.setattr(webbrowser, "open", addresses.append)
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    return addresses


def settle():
    """Wait until a browser has been opened, if one is."""
    for thread in threading.enumerate():
        if thread.name == browser.OPENER:
            thread.join()


def test_without_a_screen_no_browser_is_started(opened):
    open_browser(ADDRESS)
    settle()
    assert opened == []


@pytest.mark.parametrize("name", ["DISPLAY", "WAYLAND_DISPLAY", "BROWSER"])
def test_a_screen_or_a_named_browser_is_used(opened, monkeypatch, name):
    monkeypatch.setenv(name, ":0")
    open_browser(ADDRESS)
    settle()
    assert opened == [ADDRESS]


@pytest.mark.parametrize("error", [webbrowser.Error("none"), FileNotFoundError("none")])
def test_a_browser_that_does_not_start_is_no_error(opened, monkeypatch, error, capfd):
    def fail(address):
        raise error

    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(webbrowser, "open", fail)
    open_browser(ADDRESS)
    settle()
    assert capfd.readouterr().err == ""
