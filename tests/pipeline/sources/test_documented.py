"""What docs/data.md and docs/add-a-source.md promise about sources."""

import re
from pathlib import Path

import pytest

from rallygap.pipeline.io.schemas import POSITION_COLUMNS
from rallygap.pipeline.sources import gather as gather_module
from rallygap.pipeline.sources.registry import registry
from tests.pipeline.sources.made_up import read, write_lines

DOCS = Path(__file__).parents[3] / "docs"
GUIDE, PAGE = ((DOCS / name).read_text(encoding="utf-8") for name in ("add-a-source.md", "data.md"))


def test_the_example_of_a_new_source_works(tmp_path, monkeypatch):
    (code,) = re.findall(r"```python\n(.*?)```", GUIDE, flags=re.DOTALL)
    module = {}
    exec(code, module)
    monkeypatch.setattr(gather_module, "find_source", lambda name: module["source"])
    write_lines(tmp_path / "my_lab" / "one.txt", ["0\t100\t1000\t1060", "0.01\t100\t950\t1060"])
    recordings = read(tmp_path, "my_lab").recordings
    assert recordings["recording_id"].tolist() == ["my_lab/one"] * 2
    assert recordings[POSITION_COLUMNS].iloc[0].tolist() == pytest.approx([0.1, 1.0, 0.3])


def test_every_source_is_described():
    described = re.findall(r"^\| \[?`(\w+)`(?:\]\(#\w+\))? \|", PAGE, flags=re.MULTILINE)
    assert set(described) == set(registry())
