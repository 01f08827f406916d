"""Two versions of a file do the same if only what people read differs."""

import pytest

from rallygap.pipeline.experiments.file_content import do_the_same

CODE = "def area(r: float) -> float:\n    return 3 * r"


@pytest.mark.parametrize(
    ("name", "before", "after"),
    [
        ("a.py", CODE, 'def area(r: float) -> float:\n    """Of a disc."""\n    return 3 * r'),
        ("a.py", CODE, "# Rough.\n\n\ndef area(\n    r: float,\n) -> float:\n    return 3 * r"),
        ("a.py", "class A:\n    b: int", 'class A:\n    b: int\n    """A number."""'),
        ("a.yaml", "seed: 1", "seed: 1 # of every draw"),
        ("a.json", "{}", "{}"),
    ],
)
def test_comments_docstrings_and_layout_do_not_count(name, before, after):
    assert do_the_same(name, before, after)
    assert do_the_same(name, after, before)


@pytest.mark.parametrize(
    ("name", "before", "after"),
    [
        ("a.py", CODE, CODE.replace("3", "3.0")),
        ("a.py", "a = 'b'", "a = 'c'"),
        ("a.py", CODE, "def area("),
        ("a.yaml", "seed: 1", "seed: 1.0"),
        ("a.yaml", "seed: 1", "seed: [1"),
        ("a.json", "{}", "{ }"),
    ],
)
def test_anything_else_counts(name, before, after):
    assert not do_the_same(name, before, after)
