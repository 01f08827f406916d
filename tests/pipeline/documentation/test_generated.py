"""Pages and blocks that are generated from the code and the committed runs."""

from pathlib import Path

import pytest

from rallygap.pipeline.documentation import generated
from rallygap.pipeline.documentation.generated import regenerate
from rallygap.pipeline.runtime.errors import InputError

ROOT = Path(__file__).parents[3]


@pytest.fixture
def page(tmp_path, monkeypatch):
    """A page of a repository where one block, `size`, is known."""
    monkeypatch.setattr(generated, "PAGES", {})
    monkeypatch.setattr(generated, "BLOCKS", {"size": lambda root: "40 mm"})
    (tmp_path / "docs").mkdir()
    (tmp_path / "README.md").write_text("No block.\n")
    return tmp_path / "docs/page.md"


def test_generating_the_documentation_again_changes_nothing():
    stale = [path for path, text in regenerate(ROOT).items() if path.read_text("utf-8") != text]
    assert [str(path.relative_to(ROOT)) for path in stale] == [], "run `rallygap docs`"


def test_blocks_are_written_inside_a_line_and_on_lines_of_their_own(page):
    start, end = "<!-- generated: size -->", "<!-- end -->"
    page.write_text(f"| ball | {start}38 mm{end} |\n\n{start}\n{end}\n\nThe end.\n")
    expected = f"| ball | {start}40 mm{end} |\n\n{start}\n40 mm\n{end}\n\nThe end.\n"
    assert regenerate(page.parents[1]) == {page: expected}
    page.write_text(expected)
    assert regenerate(page.parents[1]) == {page: expected}


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("<!-- generated: weight --><!-- end -->", "unknown block, weight; known are size"),
        ("The\n<!-- generated: size -->38 mm<!-- end -->.\n", "begins a line with the block size"),
        ("<!-- generated: size --> 40 mm", "without <!-- end -->"),
    ],
)
def test_a_broken_block_is_refused_by_the_name_of_its_page(page, text, problem):
    page.write_text(text)
    with pytest.raises(InputError, match=problem) as refused:
        regenerate(page.parents[1])
    assert "page.md" in str(refused.value)
