"""From Markdown to Typst: what the documentation's pages use, and no more."""

import json
from collections.abc import Callable

from markdown_it import MarkdownIt
from markdown_it.tree import SyntaxTreeNode

SPECIAL = str.maketrans({one: f"\\{one}" for one in "\\#$*_`<>@[]~\"'/=-+"})


def typst_markup(markdown: str) -> str:
    """Return a Markdown page as Typst markup.

    Comments and the page's title are left out, links into the repository are plain text, and
    pictures and tables call the template's functions. A semicolon ends each call, so that a bracket
    that follows in the text is not taken for an argument.

    Raises:
        ValueError: the page has something that is not printed, such as a block of code.
    """
    tokens = MarkdownIt("commonmark").enable("table").parse(markdown)
    return _inside(SyntaxTreeNode(tokens))


def _inside(node: SyntaxTreeNode) -> str:
    return "".join(map(_written, node.children))


def _written(node: SyntaxTreeNode) -> str:
    if node.type not in WRITERS:
        raise ValueError(f"{node.type} is not printed")
    return WRITERS[node.type](node)


def _text(node: SyntaxTreeNode) -> str:
    return node.content.translate(SPECIAL)


def _heading(node: SyntaxTreeNode) -> str:
    level = int(node.tag[1:])
    return f"{'=' * (level - 1)} {_inside(node)}\n\n" if level > 1 else ""


def _link(node: SyntaxTreeNode) -> str:
    address = str(node.attrs["href"])
    within = "://" not in address
    return _inside(node) if within else f'#link("{address}")[{_inside(node)}];'


def _picture(node: SyntaxTreeNode) -> str:
    return f'#picture("{node.attrs["src"]}")[{_inside(node)}];'


def _table(node: SyntaxTreeNode) -> str:
    rows = [row for part in node.children for row in part.children]
    cells = "".join(f"[{_inside(cell)}],\n" for row in rows for cell in row.children)
    return f"#wide-table({len(rows[0].children)},\n{cells})\n\n"


WRITERS: dict[str, Callable[[SyntaxTreeNode], str]] = {
    "text": _text,
    "softbreak": lambda node: " ",
    "html_block": lambda node: "",
    "html_inline": lambda node: "",
    "inline": _inside,
    "code_inline": lambda node: f"#raw({json.dumps(node.content, ensure_ascii=False)});",
    "strong": lambda node: f"#strong[{_inside(node)}];",
    "em": lambda node: f"#emph[{_inside(node)}];",
    "paragraph": lambda node: f"{_inside(node)}\n\n",
    "heading": _heading,
    "link": _link,
    "image": _picture,
    "table": _table,
    "bullet_list": lambda node: f"{_inside(node)}\n",
    "list_item": lambda node: f"- {_inside(node).strip()}\n",
}
