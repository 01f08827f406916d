"""Lead: the fewest terms that explain most."""

import re

import numpy as np

from models.gap.name.sparse_formula import formula
from tests.models.gap.hidden import SETTINGS


def test_the_formula_has_the_terms_that_are_there_with_their_sizes():
    random = np.random.default_rng(0)
    rows = random.standard_normal((40, 6)) * [1.0, 10.0, 1.0, 5.0, 1.0, 2.0]
    target = rows @ [0.0, 2.0, 0.0, -3.0, 0.0, 0.0] + random.standard_normal(40)
    found = formula(list("abcdef"), rows, target, settings=SETTINGS.name)
    terms = re.findall(r"([+-][\d.e+-]+) \[(\w)\]", found)
    assert [name for _, name in terms] == ["b", "d"]
    assert np.allclose([float(value) for value, _ in terms], [2.0, -3.0], rtol=0.15)
