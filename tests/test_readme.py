"""The README is short, and its links and pictures are there."""

import re
from pathlib import Path

import pytest

from rallygap.pipeline.documentation.pictures import (
    DRAWN,
    PICTURES,
    redrawn_figures,
    renewed_pictures,
)
from tests.clone import run

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_readme_is_for_the_first_five_minutes():
    assert len(README.splitlines()) <= 150


def test_every_link_into_the_repository_leads_somewhere():
    links = re.findall(r"\]\((?!https?:)([^)#]+)", README)
    assert len(links) > 10
    assert [link for link in links if not (ROOT / link).exists()] == []


@pytest.mark.parametrize(("name", "figure"), PICTURES.items())
def test_the_pictures_of_the_documentation_are_those_of_the_last_run(name, figure):
    drawn = ROOT / "reports" / figure
    if not drawn.exists():
        pytest.skip("git keeps no figures of stages; run `dvc repro`")
    assert (ROOT / "docs" / "images" / name).read_bytes() == drawn.read_bytes()


def test_pictures_are_renewed_where_figures_differ(tmp_path):
    picture, figure = next(iter(PICTURES.items()))
    drawn = tmp_path / "reports" / figure
    drawn.parent.mkdir(parents=True)
    drawn.write_bytes(b"one")
    assert renewed_pictures(tmp_path) == [tmp_path / "docs" / "images" / picture]
    assert renewed_pictures(tmp_path) == []
    drawn.write_bytes(b"another")
    (copied,) = renewed_pictures(tmp_path)
    assert copied.read_bytes() == b"another"


def test_figures_of_kept_results_are_drawn_from_their_tables(tmp_path):
    for table, _ in DRAWN.values():
        copy = tmp_path / "reports" / table
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes((ROOT / "reports" / table).read_bytes())
    drawn = redrawn_figures(tmp_path)
    assert [path.relative_to(tmp_path / "reports").as_posix() for path in drawn] == list(DRAWN)
    for path in drawn:
        kept = ROOT / path.relative_to(tmp_path)
        assert path.read_bytes() == kept.read_bytes(), "run `rallygap docs`"
    assert redrawn_figures(tmp_path) == []


def test_every_picture_of_a_page_is_in_git():
    tracked = set(run(ROOT, "git", "ls-files", "docs", "reports").split())
    for page in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]:
        for link in re.findall(r"!\[[^]]*\]\((?!https?:)([^)]+)\)", page.read_text("utf-8")):
            shown = (page.parent / link).resolve().relative_to(ROOT).as_posix()
            assert shown in tracked, f"{page.name} shows {shown}"
