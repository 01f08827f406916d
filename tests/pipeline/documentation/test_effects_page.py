"""The catalogue's page has a row for every parameter."""

from models.ball.catalogue import catalogue
from pipeline.documentation.effects_page import catalogue_page


def test_every_effect_and_parameter_has_its_row():
    rows = [line for line in catalogue_page().splitlines() if line.startswith("| `")]
    assert len(rows) == sum(len(effect.parameters) for effect in catalogue().values())
