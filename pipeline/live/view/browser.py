"""Open the view in the browser of a user who sits at this machine."""

import os
import sys
import webbrowser
from contextlib import suppress
from threading import Thread

WITHOUT_X = ("darwin", "win32")  # platforms whose screen no variable tells
OPENER = "browser opener"  # name of the thread
SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")


def open_browser(address: str) -> None:
    """Open a page in the browser, if there is a screen or the user has named a browser.

    Elsewhere, ``webbrowser`` would start a browser of text, which takes the terminal. A browser
    that is slow to start is not waited for, and one that does not start is no error.
    """
    if _has_browser():
        Thread(target=_open, args=(address,), name=OPENER, daemon=True).start()


def _has_browser() -> bool:
    """Whether there is a screen, or the user has named a browser in ``BROWSER``."""
    return sys.platform in WITHOUT_X or any(os.environ.get(name) for name in SCREENS)


def _open(address: str) -> None:
    with suppress(webbrowser.Error, OSError):
        webbrowser.open(address)
