"""The printed results: what Markdown becomes, and a document that is the same every time."""

import re
from html import unescape

import pytest
from hypothesis import given
from hypothesis import strategies as st
from markdown_it import MarkdownIt
from PIL import Image

from rallygap.pipeline.io.artifacts import write_text
from rallygap.pipeline.print.results_pdf import PAGE, PDF, results_pdf
from rallygap.pipeline.print.typst_markup import typst_markup

typst = pytest.importorskip("typst")

MARKDOWN = """# Results

## Errors of *all* <!-- generated: name -->predictors<!-- end -->

See [the method](method.md#errors), [the set](https://example.org/set) and `a_b.csv`.

<!-- generated: table -->
| set | error (mm) |
| --- | --- |
| `arena` | 19 (17 to 21) |
<!-- end -->

- one
- **two**
"""
TEMPLATE = """#let wide-table(columns, ..cells) = cells.pos().map(one => par(one)).join()
#let picture(path, caption) = caption
"""


def plain(html):
    """The words of a page, whatever its tags."""
    body = re.sub(r"(?s)<head>.*?</head>|<!--.*?-->", "", html)
    spaced = re.sub(r"</(p|h\d|li|td|th)>|<br>", " ", body)
    return unescape(re.sub(r"<[^>]*>", "", spaced)).replace("\xa0", " ").split()


def printed(markdown):
    """The words that Typst reads."""
    return plain(
        typst.compile((TEMPLATE + typst_markup(markdown)).encode(), format="html").decode()
    )


def rendered(markdown):
    """The words that a browser shows, but for the title."""
    html = MarkdownIt("commonmark").enable("table").render(markdown)
    return plain(re.sub(r"(?s)<h1>.*?</h1>", "", html))


def test_the_words_are_those_of_the_page():
    assert printed(MARKDOWN) == rendered(MARKDOWN)


@given(st.text("ab 12#$*_`<>@[]~\"'/=-+\\.(){}!|:;&%^,", min_size=1, max_size=30))
def test_no_text_is_taken_for_markup(text):
    escaped = re.sub(r"([^\w\s])", r"\\\1", text)
    assert "".join(printed(f"x {escaped} y")) == "".join(rendered(f"x {escaped} y"))


@given(st.text("ab 12#$*_<>@[]~\"'/=-+\\.(){}!|:;&%^,", min_size=1, max_size=30))
def test_code_is_printed_as_it_is(text):
    markdown = f"x `{text}` y"
    assert "".join(printed(markdown)) == "".join(rendered(markdown))


def test_links_lead_out_of_the_repository_only():
    markup = typst_markup(MARKDOWN)
    assert '#link("https://example.org/set")[the set]' in markup
    assert "method.md" not in markup


def test_what_is_not_printed_is_refused():
    with pytest.raises(ValueError, match="fence is not printed"):
        typst_markup("```\ncode\n```")


def test_the_same_page_gives_the_same_document(tmp_path):
    write_text(tmp_path / PAGE, MARKDOWN + "\n![A picture](images/dot.png)\n")
    write_text(tmp_path / "CITATION.cff", "title: rallygap\nabstract: About it.\nversion: 1.2.3\n")
    (tmp_path / "docs" / "images").mkdir()
    Image.new("RGB", (4, 4)).save(tmp_path / "docs" / "images" / "dot.png")
    first = results_pdf(tmp_path).read_bytes()
    assert first.startswith(b"%PDF-")
    assert results_pdf(tmp_path).read_bytes() == first
    assert (tmp_path / PDF).exists()
