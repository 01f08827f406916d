"""Findings in words: what a reader learns first."""

from models.gap.verdict import Unexplained
from pipeline.gap.summary import sight_lines
from tests.pipeline.verdicts import GAP, GRAVITY, WIND, findings, verdict


def text(*arguments, **changes):
    return " ".join(findings(verdict(*arguments, **changes)).sentences)


def test_agreement_is_said_with_how_far_it_reaches():
    said = text("no_gap", ())
    assert said.startswith("No gap: 4 shots of hall agree with sim.yaml as far as they can tell.")
    assert "err by 21.0 mm; without any gap they would err by 7.0 mm" in said
    assert "Of 5 numbers in question these shots can show 3; they are blind to buoyancy" in said
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


def test_causes_that_predict_worse_are_said_to_be_refused():
    worse = GAP.model_copy(update={"closer_mm": (-9.0, -2.0)})
    refused = "amended.yaml is the simulator as it was"
    assert refused in text("unknown", gap=worse)
    assert refused not in text("named")


def test_where_it_arises_and_what_it_differs_with_is_said():
    said = text()
    assert "The gap arises 100 % in flight, 0 % at the table and 0 % in the measurement." in said
    assert "differs most with the speed at launch: 40 % of its variance, p below 0.001." in said


def test_landings_are_said_in_place_and_time():
    said = text()
    assert "land, predictions err by 14.0 mm and 1.90 ms with the amended simulator" in said
    assert "by 31.0 mm and 4.00 ms with the one as it was" in said


def test_what_shots_can_show_is_said_before_anything_is_looked_for():
    found = findings()
    sight = found.verdict.detectable, found.verdict.blind_to
    assert list(sight_lines(found.measured, found.simulator, sight)) == [
        "4 shots of hall can show, from this size on:",
        "  wind.x    0.04 m/s",
        "  gravity   0.06 m/s^2",
        "  friction  0.012",
        "They are blind to buoyancy, spin_decay.",
    ]


def test_shots_too_short_to_predict_are_no_obstacle():
    assert "Predictions" not in text(gap=None)
