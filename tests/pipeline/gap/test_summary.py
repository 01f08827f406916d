"""The verdict in sentences has the numbers that a reader needs first."""

from models.gap.verdict import DetectionLimits, Unexplained
from pipeline.gap.summary import detection_lines
from tests.pipeline.verdicts import GAP, GRAVITY, WIND, findings, verdict


def text(*arguments, **changes):
    return " ".join(findings(verdict(*arguments, **changes)).sentences)


def test_no_gap_comes_with_errors_and_detection_limits():
    message = text("no_gap", ())
    assert message.startswith("No gap: 4 shots of lab agree with the simulator sim.yaml")
    assert "200 ms: 21.0 mm with the nominal simulator; prediction floor 7.0 mm" in message
    assert "3 of 5 parameters; not buoyancy.b, spin_decay.c" in message
    assert "arises" not in message


def test_a_cause_comes_with_estimate_interval_share_and_alternatives():
    message = text("ambiguous", (WIND, GRAVITY))
    assert "2 causes" in message
    assert "estimate 0.61 m/s (95 % 0.59 to 0.63), missing in the simulator; 70 % of" in message
    assert "10.3 m/s^2 (95 % 10.2 to 10.4), simulator 9.81; 30 % of the gap" in message
    assert "Not separable from buoyancy.b." in message
    assert "21.0 mm with the nominal simulator, 8.0 mm with the amended one" in message
    assert "31.0 mm and 4.00 ms with the nominal simulator, 14.0 mm and 1.90 ms with" in message


def test_unexplained_structure_comes_with_its_phase_and_a_formula():
    rest = Unexplained(share=0.6, p_value=1e-4, phase="table", formula="+0.1 [slip]")
    message = text("unknown", (), unexplained=rest)
    assert "Unexplained structure at the table: 60 % of the gap." in message
    assert "+0.1 [slip]" in message


def test_causes_that_predict_worse_are_rejected():
    worse = GAP.model_copy(update={"reduction_mm": (-9.0, -2.0)})
    rejected = "amended.yaml is the nominal simulator"
    assert rejected in text("unknown", gap=worse)
    assert rejected not in text("named")


def test_phases_and_the_first_covariate_are_reported():
    assert "100 % in flight, 0 % at the table and 0 % in the measurement" in text()
    assert "on speed at launch, which explains 40 % of its variance (p < 0.001)" in text()


def test_detection_limits_are_listed_with_units():
    limits = DetectionLimits({"wind.x": 0.04, "table_bounce.friction": 0.012}, ("buoyancy.b",))
    _, *sizes, others = detection_lines(findings().measured, limits)
    assert [line.split() for line in sizes] == [
        ["wind.x", "0.04", "m/s"],
        ["table_bounce.friction", "0.012"],
    ]
    assert "buoyancy.b" in others


def test_a_verdict_without_prediction_errors_has_sentences():
    assert "Prediction error" not in text(gap=None)
