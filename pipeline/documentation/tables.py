"""Tables of results in README and docs: blocks whose query stands in the page.

A block is a comment with a query in YAML, the table, and an end:

    <!-- table: learning_curves/errors.csv
    rows: horizon_ms == 300
    columns:
      predictor: "{predictor}"
      "{recordings} recordings": "{mean:.0f} ({ci_low:.0f} to {ci_high:.0f})"
    -->
    | predictor | 10 recordings | 30 recordings |
    ...
    <!-- end -->

Cells and heads are format strings whose fields are expressions of pandas over the rows. A head with
fields spreads its column: one column for each head, one line for rows that agree in the others.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from string import Formatter
from typing import Any

import pandas as pd
import yaml
from pydantic import BaseModel, ConfigDict

from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.io.markdown import markdown_table
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.web.labels import PREDICTORS, SIMULATORS

MISSING = "–"
LABELS = {"predictor": PREDICTORS, "other": PREDICTORS, "simulator": SIMULATORS}  # by column
_BLOCK = re.compile(r"(<!-- (table: .*?)-->\n)(.*?)(?=<!-- end -->)", re.DOTALL)


class Query(BaseModel):
    """What a block shows; its steps are applied in this order.

    Attributes:
        table: a CSV or JSON file, relative to ``reports/``.
        within: key of a JSON file whose content is read instead of the whole.
        levels: names of the columns with the keys of a nested JSON file, from the outermost.
        transpose: whether the table has a column, not a row, for each row to show.
        rows: query for the rows to keep.
        let: new columns and their expressions.
        by: columns whose groups become rows.
        take: columns of these groups: a column of the table and how its values are combined.
        columns: heads and cells.
    """

    model_config = ConfigDict(extra="forbid")

    table: str
    within: str = ""
    levels: list[str] = []
    transpose: bool = False
    rows: str = ""
    let: dict[str, str] = {}
    by: list[str] = []
    take: dict[str, tuple[str, str]] = {}
    columns: dict[str, str]

    def read(self, reports: Path) -> pd.DataFrame:
        """Return the rows of the file that the block shows, with their new columns."""
        path = reports / self.table
        if path.suffix == ".json":
            content = read_json(path)
            nested = content[self.within] if self.within else content
            table = pd.DataFrame(_records(nested, self.levels))
        else:
            table = pd.read_csv(path)
        if self.transpose:
            table = table.set_index(table.columns[0]).T.rename_axis("name").reset_index()
        if self.rows:
            table = table.query(self.rows, engine="python")
        for name, expression in self.let.items():
            table = table.assign(**{name: _values(expression, table)})
        if self.by:
            table = table.groupby(self.by, sort=False).agg(**self.take).reset_index()
        return table


def rendered(query: Query, reports: Path) -> str:
    """Return what a query shows, as a Markdown table."""
    table = query.read(reports)
    heads = {head: _filled(head, table) for head in query.columns}
    cells = {head: _filled(cell, table) for head, cell in query.columns.items()}
    fixed = [head for head in query.columns if "{" not in head]
    lines: dict[tuple[str, ...], dict[str, str]] = {}
    names = dict.fromkeys(name for names in heads.values() for name in names)
    for row in range(len(table)):
        line = lines.setdefault(tuple(cells[head][row] for head in fixed), {})
        line.update({heads[head][row]: cells[head][row] for head in heads})
    rows = [[line.get(name, MISSING) for name in names] for line in lines.values()]
    return markdown_table(list(names), rows)


def with_tables(path: Path, root: Path) -> str:
    """Return the text of a page with its tables as their queries give them.

    Args:
        path: of the page.
        root: of the repository.

    Raises:
        InputError: a block is broken, or its query does not fit its file.
    """

    def written(block: re.Match[str]) -> str:
        try:
            query = Query.model_validate(yaml.safe_load(block[2]))
            return f"{block[1]}{rendered(query, root / 'reports')}\n"
        except (OSError, LookupError, NameError, TypeError, ValueError, yaml.YAMLError) as error:
            problem = f"has a table that cannot be made: {error}"
            raise InputError(path, problem, field=block[2].splitlines()[0]) from None

    text = path.read_text(encoding="utf-8")
    if len(_BLOCK.findall(text)) != text.count("<!-- table:"):
        raise InputError(path, "has a table without its columns or without <!-- end -->")
    return _BLOCK.sub(written, text)


def pages(root: Path) -> list[Path]:
    """Return README and the pages of the documentation."""
    return [root / "README.md", *sorted((root / "docs").glob("*.md"))]


def _records(content: Any, levels: list[str]) -> Iterator[dict[str, Any]]:
    """Yield the objects at the last level of nested ones, with the keys that lead to them."""
    if isinstance(content, dict) and not levels:
        yield content
    elif isinstance(content, dict | list) and levels:
        items = content.items() if isinstance(content, dict) else enumerate(content)
        for key, value in items:
            for record in _records(value, levels[1:]):
                yield {levels[0]: key, **record}


def _filled(template: str, table: pd.DataFrame) -> list[str]:
    """Return a format string filled with each row; a dash where a value is missing."""
    cells = [""] * len(table)
    for text, field, form, _ in Formatter().parse(template):
        values = _texts(field, form or "", table) if field else [""] * len(table)
        cells = [
            MISSING if MISSING in (cell, value) else cell + text + value
            for cell, value in zip(cells, values, strict=True)
        ]
    return cells


def _texts(field: str, form: str, table: pd.DataFrame) -> list[str]:
    """Return the values of an expression as they are shown."""
    values = list(table[field] if field in table else _values(field, table))
    if field in LABELS:
        values = [LABELS[field].get(value, value) for value in values]
    return [_text(value, form) for value in values]


def _values(expression: str, table: pd.DataFrame) -> Any:
    return table.eval(expression, engine="python")


def _text(value: Any, form: str) -> str:
    if isinstance(value, list):
        return ", ".join(_text(item, form) for item in value) or MISSING
    if pd.isna(value):
        return MISSING
    if isinstance(value, bool):
        return "yes" if value else "no"
    return format(value, form)
