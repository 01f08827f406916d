"""The README is short, and its links and pictures are there."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_readme_is_for_the_first_five_minutes():
    assert len(README.splitlines()) <= 150


def test_every_link_into_the_repository_leads_somewhere():
    links = re.findall(r"\]\((?!https?:)([^)#]+)", README)
    assert len(links) > 10
    assert [link for link in links if not (ROOT / link).exists()] == []


@pytest.mark.parametrize(
    ("stage", "figure", "name"),
    [
        ("close_gap", "causes_arena.png", "causes_arena.png"),
        ("close_gap", "errors_arena.png", "errors_arena.png"),
        ("hidden_effects", "accuracy.png", "exam_accuracy.png"),
        ("hidden_effects", "confusion.png", "exam_confusion.png"),
    ],
)
def test_the_pictures_of_the_documentation_are_those_of_the_last_run(stage, figure, name):
    drawn = ROOT / "reports" / stage / "figures" / figure
    if not drawn.exists():
        pytest.skip(f"git keeps no figures of stages; run `dvc repro {stage}`")
    assert (ROOT / "docs" / "images" / name).read_bytes() == drawn.read_bytes()
