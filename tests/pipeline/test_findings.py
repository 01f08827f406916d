"""Findings in words: what a reader learns first."""

from models.gap.verdict import Unexplained
from tests.pipeline.verdicts import GRAVITY, WIND, findings, verdict


def text(*arguments, **changes):
    return " ".join(findings(verdict(*arguments, **changes)).sentences)


def test_agreement_is_said_with_how_far_it_reaches():
    said = text("no_gap", ())
    assert said.startswith("No gap: 4 shots of hall agree with sim.yaml as far as they can tell.")
    assert "err by 21.0 mm; without any gap they would err by 7.0 mm" in said
    assert "Of 5 numbers in question these shots can show 3; they are blind to buoyancy, kp" in said
    assert "arises" not in said


def test_a_missing_effect_is_said_with_size_interval_and_share():
    said = text()
    assert "differ from sim.yaml by one cause." in said
    assert "wind.x (" in said
    assert "is missing: 0.61 m/s (95 %: 0.59 to 0.63), 70 % of the gap." in said
    assert "by 8.0 mm with the amended simulator, by 21.0 mm with the one as it was" in said


def test_a_wrong_value_is_said_with_what_else_it_could_be_and_what_would_decide():
    said = text("ambiguous", (WIND, GRAVITY))
    assert "by 2 causes" in said
    assert "is 10.3 m/s^2 (95 %: 10.2 to 10.4) and not 9.81, 30 % of the gap." in said
    assert "It could also be buoyancy; to decide, shoot both ways." in said


def test_what_has_no_name_is_said_with_its_place_and_a_lead():
    left = Unexplained(share=0.6, p_value=1e-4, where="table", lead="+0.1 [slip]")
    said = text("unknown", (), unexplained=left)
    assert "no effect of the catalogue explains" in said
    assert "acts at the table, 60 % of the gap. A lead and not a name: +0.1 [slip]." in said


def test_shots_too_short_to_predict_are_no_obstacle():
    assert "Predictions" not in text(gap=None)
