"""The catalogue's page says what the catalogue holds."""

from pathlib import Path

from models.ball.catalogue import catalogue
from pipeline.documentation.effects_page import catalogue_page

PAGE = Path(__file__).parents[3] / "docs" / "effects.md"


def test_the_committed_page_is_the_catalogue():
    assert PAGE.read_text(encoding="utf-8") == catalogue_page() + "\n", (
        "run `rallygap effects > docs/effects.md`"
    )


def test_every_effect_and_parameter_has_its_row():
    rows = [line for line in catalogue_page().splitlines() if line.startswith("| `")]
    assert len(rows) == sum(len(effect.parameters) for effect in catalogue().values())
