"""Start tags in the text of a scene, and changes to their attributes that keep all other text."""

import html
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

# Comments, sections and instructions come first: what looks like a tag in them is none. Unlike a
# parser of XML, and like MuJoCo's, this takes comments that have "--" in them.
TOKEN = re.compile(
    r"<!--.*?-->|<!\[CDATA\[.*?\]\]>|<\?.*?\?>|<![^>]*>|(?P<end></[^>]*>)"
    r"|<(?P<name>[^\s/>!?]+)(?:[^>\"']|\"[^\"]*\"|'[^']*')*>",
    re.DOTALL,
)
ATTRIBUTE = re.compile(r"([^\s=\"'/<]+)\s*=\s*(\"[^\"]*\"|'[^']*')")


@dataclass(frozen=True)
class Tag:
    """A start tag.

    Attributes:
        name: of the element.
        start: offset of its ``<`` in the text.
        text: of the tag, from ``<`` to ``>``.
        parents: the tags of the elements around it, the outermost first.
    """

    name: str
    start: int
    text: str
    parents: tuple["Tag", ...]

    @property
    def end(self) -> int:
        """Offset after its ``>``."""
        return self.start + len(self.text)

    @property
    def attributes(self) -> dict[str, str]:
        """Its attributes as they are written."""
        return {name: html.unescape(value[1:-1]) for name, value in ATTRIBUTE.findall(self.text)}

    def parent(self, name: str) -> "Tag | None":
        """Return the nearest element of a name around it."""
        return next((one for one in reversed(self.parents) if one.name == name), None)


@dataclass(frozen=True)
class Edit:
    """A piece of text in the place of another.

    Attributes:
        start: offset of the first character that goes.
        end: offset after the last one; ``start`` where nothing goes.
        text: that comes.
    """

    start: int
    end: int
    text: str


def tags(text: str) -> Iterator[Tag]:
    """Yield the start tags of a text, in its order."""
    open_tags: list[Tag] = []
    for token in TOKEN.finditer(text):
        if token["end"] is not None:
            del open_tags[-1:]
        elif token["name"] is not None:
            tag = Tag(token["name"], token.start(), token[0], tuple(open_tags))
            yield tag
            if not token[0].endswith("/>"):
                open_tags.append(tag)


def with_attributes(tag: str, values: Mapping[str, str]) -> str:
    """Return the text of a tag with attributes changed, in their quotes, or added at its end."""
    for name, value in values.items():
        found = next((one for one in ATTRIBUTE.finditer(tag) if one[1] == name), None)
        if found is not None:
            tag = f"{tag[: found.start(2) + 1]}{value}{tag[found.end(2) - 1 :]}"
            continue
        close = re.search(r"\s*/?>$", tag)
        assert close is not None  # a tag ends so
        tag = f'{tag[: close.start()]} {name}="{value}"{tag[close.start() :]}'
    return tag


def with_edits(text: str, edits: Sequence[Edit]) -> str:
    """Return a text with edits that do not overlap; at one place, in their order."""
    pieces, place = [], 0
    for edit in sorted(edits, key=lambda one: one.start):
        pieces += [text[place : edit.start], edit.text]
        place = edit.end
    return "".join([*pieces, text[place:]])


def comments_above(text: str, place: int, comments: Sequence[str]) -> str:
    """Return comments to insert before a tag: each on a line, where the tag begins one.

    Args:
        text: of the scene.
        place: offset of the tag.
        comments: what they say, one each.
    """
    indent = text[text.rfind("\n", 0, place) + 1 : place]
    gap = line_end(text) + indent if not indent.strip() else " "
    return "".join(f"<!-- {_harmless(one)} -->{gap}" for one in comments)


def line_end(text: str) -> str:
    """Return how lines of a text end."""
    return "\r\n" if "\r\n" in text else "\n"


def _harmless(comment: str) -> str:
    """Return a comment without two hyphens in a row, which end one."""
    return re.sub(r"-(?=-)", "- ", comment)
