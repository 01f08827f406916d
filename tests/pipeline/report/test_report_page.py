"""The report page as text: complete, escaped, accessible and the same every time."""

import re
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageSequence

from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.web.figure_style import CONTACT_COLOURS, predictor_colour
from rallygap.pipeline.web.report_items import ReportAnimation
from tests.pipeline.report.example_reports import OFFSETS, made_up_page, make_reports, moving_dot

STYLES = Path(__file__).parents[3] / "pipeline" / "web" / "templates" / "page.css"
HOSTILE = "</script><img src=x onerror=alert(1)>\"'&"


class Tags(HTMLParser):
    """The tags of a page in order, each with the names and values of its attributes."""

    def __init__(self, page):
        super().__init__()
        self.found = []
        self.feed(page)

    def handle_starttag(self, tag, attributes):
        self.found.append((tag, dict(attributes)))

    def named(self, name):
        return [attributes for tag, attributes in self.found if tag == name]


def palettes():
    """The page's colours by name, light and dark."""
    light, dark = STYLES.read_text().split("@media screen", maxsplit=1)
    pattern = r"--([a-z]+): (#[0-9a-f]{6})"
    light = dict(re.findall(pattern, light))
    return [light, {**light, **dict(re.findall(pattern, dark))}]


def contrast(*colours):
    """The contrast ratio of two colours as the Web Content Accessibility Guidelines define it."""
    channels = np.array([[*bytes.fromhex(colour[1:])] for colour in colours]) / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    darker, brighter = sorted(linear @ [0.2126, 0.7152, 0.0722])
    return (brighter + 0.05) / (darker + 0.05)


def test_the_page_opens_with_the_results_that_the_reports_have(page):
    main = page.split("<main>", maxsplit=1)[1]
    first = main.split("</section>", maxsplit=1)[0]
    assert "Stage <code>learning_curves</code>" in first
    for stage in ("segment", "evaluate_predictor", "sim2real"):
        assert f"Produced by stage <code>{stage}</code>" in main
    assert "amended by 300 recordings errs 31 mm, a transformer trained on 2,000 90 mm" in first
    assert len(Tags(first).named("img")) == 1


def test_names_from_the_data_cannot_become_markup(page, tmp_path):
    items = make_reports(tmp_path, title=HOSTILE, shot=HOSTILE)
    hostile = Tags(made_up_page(tmp_path, items))
    assert [tag for tag, _ in hostile.found] == [tag for tag, _ in Tags(page).found]
    assert all("onerror" not in attributes for _, attributes in hostile.found)


def test_headings_descend_one_level_at_a_time(page):
    levels = [int(tag[1]) for tag, _ in Tags(page).found if re.fullmatch("h[1-6]", tag)]
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))


def test_links_lead_to_items_and_nothing_outside_the_page(page):
    tags = Tags(page)
    ids = [attributes["id"] for _, attributes in tags.found if "id" in attributes]
    assert len(ids) == len(set(ids))
    assert all(link["href"][1:] in ids for link in tags.named("a"))
    links = [value for _, a in tags.found for key, value in a.items() if key in ("src", "href")]
    assert all(link.startswith(("#", "data:")) for link in links)


@pytest.mark.parametrize("name", ["segment/contacts.csv", "evaluate_predictor/figures/spindoe.png"])
def test_missing_file_is_named(made_up, name):
    root, items = made_up
    file = root / "reports" / name
    elsewhere = file.rename(root / "elsewhere")
    with pytest.raises(InputError, match=f"{name}: cannot be read; run its stage again"):
        made_up_page(root, items)
    elsewhere.rename(file)


@pytest.mark.parametrize("palette", palettes(), ids=["light", "dark"])
def test_text_and_lines_stand_out_from_their_background(palette):
    lines = [*map(predictor_colour, OFFSETS), *CONTACT_COLOURS.values()]
    for background in (palette["page"], palette["card"]):
        texts = [palette[name] for name in ("ink", "muted", "accent")]
        lines += [palette[name] for name in ("good", "bad", "arm")]
        assert min(contrast(text, background) for text in texts) >= 4.5
        assert min(contrast(line, background) for line in lines) >= 3.0


def test_an_animation_has_every_pixel_and_rests_on_its_last_frame(tmp_path):
    ReportAnimation(moving_dot(), "dot", title="", caption="").write(tmp_path / "dot.png")
    with Image.open(tmp_path / "dot.png") as animation:
        frames = ImageSequence.Iterator(animation)
        seen = [(np.asarray(frame), frame.info["duration"]) for frame in frames]
        assert animation.info["loop"] == 0  # without end
    np.testing.assert_array_equal([pixels for pixels, _ in seen], moving_dot())
    assert [duration for _, duration in seen] == [*[40] * 4, 1000]
