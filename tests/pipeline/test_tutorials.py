"""The commands and the code of the tutorials of `diagnose` work, and print what the pages show."""

import re
import subprocess
from pathlib import Path

import pytest

from experiments.clone import ROOT, environment
from experiments.exam.interface import rounded

pytestmark = pytest.mark.slow

BLOCK = re.compile(
    r"(?:Save this as `(?P<file>[\w.]+)`[^\n]*\n\n)?```(?P<kind>\w*)\n(?P<text>.*?)```", re.S
)
INSTALL = "pip install"
LEFT_OUT = "…\n"
UNROUNDED = re.compile(r"\d+\.\d{9,}")  # whose last digits depend on the processor
RALLYGAP = """rallygap() { python -c "from rallygap.pipeline.cli import main; main()" "$@"; }\n"""


def blocks(page):
    """A page's blocks but those that install: their kinds, texts, and files to save them as."""
    found = BLOCK.finditer((ROOT / "docs" / page).read_text(encoding="utf-8"))
    return [(one["kind"], one["text"], one["file"]) for one in found if INSTALL not in one["text"]]


@pytest.fixture
def folder(tmp_path):
    """A folder in what looks like a clone."""
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    (tmp_path / "tutorial").mkdir()
    return tmp_path / "tutorial"


@pytest.mark.parametrize(
    ("page", "texts"), [("tutorial-diagnose.md", 7), ("tutorial-simulator.md", 6)]
)
def test_a_newcomer_sees_what_the_page_shows(folder, page, texts):
    if page == "tutorial-simulator.md":
        pytest.importorskip("mujoco")
    printed, shown = "", 0
    for kind, text, file in blocks(page):
        if kind == "bash":
            printed = run(folder, text)
        elif file:
            (folder / file).write_text(text)
        else:
            assert shows(text, printed), printed
            shown += 1
    assert shown == texts


def run(folder: Path, command: str) -> str:
    ended = subprocess.run(
        ["bash", "-ec", RALLYGAP + command],
        cwd=folder,
        env={**environment(folder), "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


def shows(text: str, printed: str) -> bool:
    """Whether a text is what was printed, but for the lines that it leaves out."""
    parts = (re.escape(part) for part in compared(text).split(LEFT_OUT))
    return re.fullmatch("(.*\n)?".join(parts), compared(printed), re.S) is not None


def compared(text: str) -> str:
    return UNROUNDED.sub(lambda number: str(rounded(float(number[0]))), text)
