"""Start tags in text that looks like tags, and attributes changed in place."""

from rallygap.pipeline.engines.export.scene.tags import (
    Edit,
    comments_above,
    tags,
    with_attributes,
    with_edits,
)

TEXT = """<?xml version="1.0"?><!-- <a b="1"/> -- <c> -->
<root><![CDATA[<d/>]]><one x='a > b' y = "2"/><two><three/></two><four
/></root>"""


def test_tags_in_comments_and_sections_are_none():
    found = list(tags(TEXT))
    assert [one.name for one in found] == ["root", "one", "two", "three", "four"]
    assert [[parent.name for parent in one.parents] for one in found[2:]] == [
        ["root"], ["root", "two"], ["root"],
    ]  # fmt: skip
    assert all(TEXT[one.start : one.end] == one.text for one in found)
    assert found[1].attributes == {"x": "a > b", "y": "2"}


def test_attributes_change_in_their_quotes_and_new_ones_come_last():
    tag = "<geom  size = '1'\n  pos=\"0 0\" />"
    changed = with_attributes(tag, {"size": "2", "mass": "3"})
    assert changed == '<geom  size = \'2\'\n  pos="0 0" mass="3" />'
    assert with_attributes("<option>", {"wind": "1 0 0"}) == '<option wind="1 0 0">'
    assert with_attributes('<g xpos="1"/>', {"pos": "2"}) == '<g xpos="1" pos="2"/>'


def test_edits_at_one_place_keep_their_order():
    edits = [Edit(4, 4, "d"), Edit(1, 1, "x"), Edit(1, 2, "B")]
    assert with_edits("abc!", edits) == "axBc!d"


def test_a_comment_has_a_line_of_its_own_where_the_tag_has_one():
    text = "<a>\r\n  <b/>"
    assert comments_above(text, text.index("<b"), ["one"]) == "<!-- one -->\r\n  "
    assert comments_above("<a><b/>", 3, ["-- two --"]) == "<!-- - - two - - --> "
