"""The verdict in sentences has the numbers that a reader needs first."""

import pytest

from rallygap.models.gap.verdict import Check, DetectionLimits, NetErrors, Unexplained, Variation
from rallygap.pipeline.gap.summary import answer_title, detection_lines
from tests.pipeline.verdicts import (
    CAMERA,
    GAP,
    GRAVITY,
    LABELS_MISFIT,
    MINOR,
    MISFIT,
    WIND,
    findings,
    verdict,
)

WORSE = GAP.model_copy(update={"reduction_mm": (-9.0, -2.0), "after_mm": (12.0, 25.0, 48.0)})


def outcome(*arguments, **changes):
    return findings(verdict(*arguments, **changes)).outcome


def text(*arguments, **changes):
    found = findings(verdict(*arguments, **changes))
    return " ".join([*found.outcome, *found.details])


def test_no_gap_comes_with_errors_and_minimum_detectable_effects():
    message = text("no_gap", ())
    assert message.startswith("No gap: 4 shots of lab agree with the simulator sim.yaml")
    assert "200 ms ahead: 21.0 mm; prediction floor 7.0 mm" in message
    assert "3 of 5 parameters; not buoyancy.b, spin_decay.c" in message
    assert "arises" not in message


def test_no_gap_but_for_minor_structure_says_so():
    message = text("no_gap", (MINOR,))
    assert message.startswith("No gap but for minor structure: 4 shots of lab agree")
    assert "after amending" not in message
    assert answer_title(verdict("no_gap", ())) == "No gap"


def test_a_cause_comes_with_estimate_interval_share_worth_and_alternatives():
    message = text("ambiguous", (WIND, GRAVITY))
    assert "2 leading causes found" in message
    assert "estimate 0.61 m/s (95 % 0.59 to 0.63), missing in the simulator; 70 % of" in message
    assert "without it predictions err 5.3 mm more (95 % 2.8 to 7.9)." in message
    assert "10.3 m/s^2 (95 % 10.2 to 10.4), simulator 9.81; 30 % of the gap" in message
    assert "without it predictions err 0.4 mm less (95 % -0.2 to 1.1)." in message
    assert "Not separable from buoyancy.b." in message
    assert "21.0 mm before, 8.0 mm after amending; prediction floor 7.0 mm" in message
    assert "31.0 mm and 4.00 ms before, 14.0 mm and 1.90 ms after amending" in message


def test_the_outcome_goes_from_errors_over_causes_to_what_to_do():
    rest = Unexplained(share=0.06, p_value=1e-4, phase="table", formula="+0.1 [slip]")
    lines = outcome("named", (WIND, CAMERA, MINOR), unexplained=rest)
    starts = [
        "Named: ",
        "Prediction error on",
        "Prediction error at landing",
        "Leading cause wind.x",
    ]
    starts += [
        "Sensor fault camera_distortion.amplitude",
        "Minor structure, not amended: spin_decay.c",
    ]
    starts += ["Unexplained structure at the table: 6 %", "Candidate formula", "Next: "]
    assert [line[: len(start)] for line, start in zip(lines, starts, strict=True)] == starts
    assert "1 leading cause and 1 sensor fault identified" in lines[0]
    assert "4 % of the gap" in lines[5]


def test_errors_after_the_net_follow_those_of_other_shots():
    errors = NetErrors(contacts=40, held_out=13, horizon_ms=100, before_mm=321.9, after_mm=18.6)
    lines = outcome("named", (WIND,), net=errors)
    text = "up to 100 ms after the net: 321.9 mm before, 18.6 mm after amending (13 held-out"
    assert text in lines[3]


def test_a_failed_check_is_said_first():
    first, second, *_ = outcome(checks=(MISFIT,))
    assert first == (
        "The fitted model does not describe these shots: predictions err 2.2 times as much as it "
        "expects (95 % 1.4 to 3.2; allowed 0.75 to 1.33). Do not rely on intervals and small "
        "causes."
    )
    assert second.startswith("Named: ")


def test_amended_predictions_that_are_worse_are_said_first():
    first, *_, last = outcome(gap=WORSE)
    assert "worse than the nominal one: held-out predictions err 5.0 mm more" in first
    assert "(95 % 2.0 to 9.0). Do not use amended.yaml." in first
    assert last.startswith("Next: keep the nominal simulator.")


@pytest.mark.parametrize(
    ("arguments", "changes", "step"),
    [
        (("named",), {}, "predict with amended.yaml, and diagnose new recordings"),
        (("ambiguous", (WIND, GRAVITY)), {}, "to tell gravity.g from buoyancy.b, record shots in"),
        (("ambiguous", (WIND,)), {}, "amended.yaml is one of several possible simulators"),
        (("no_gap", ()), {}, "nothing to amend. Record 20 shots or more"),
        (("unknown", ()), {}, "the catalogue lacks an effect; add one"),
        (("named",), {"checks": (MISFIT,)}, "look for errors of the recordings"),
        (("named",), {"checks": (LABELS_MISFIT,)}, "check signs, axes and units of the spin"),
    ],
)
def test_what_to_do_next_follows_from_the_verdict(arguments, changes, step):
    assert step in outcome(*arguments, **changes)[-1]


def test_labels_that_err_too_much_are_said_in_percent_of_the_spin():
    assert (
        "spin labels err by 62 % of the spin (allowed 50 %)" in outcome(checks=(LABELS_MISFIT,))[0]
    )


def test_unexplained_structure_comes_with_its_phase_and_a_formula():
    rest = Unexplained(share=0.6, p_value=1e-4, phase="table", formula="+0.1 [slip]")
    message = text("unknown", (), unexplained=rest)
    assert "Unexplained structure at the table: 60 % of the gap." in message
    assert "+0.1 [slip]" in message
    assert "the catalogue lacks an effect at the table" in message


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


def test_a_variation_is_listed_with_its_size_and_what_to_do():
    drift = Variation(
        identity="drag.cd",
        kind="drift",
        unit="1",
        size=0.1,
        interval=(0.08, 0.12),
        p_value=1e-5,
        possible=("drag.cd", "linear_drag.k1"),
    )
    message = text("unknown", (), variations=(drift,))
    assert (
        "drag.cd (the air slows the ball) drifts over the session, by 0.1 (95 % 0.08 to" in message
    )
    assert "not amended. Not separable from linear_drag.k1." in message
    assert "diagnose the parts of the session by themselves" in message
    balls = drift.model_copy(update={"kind": "between_shots"})
    assert "differs from shot to shot, with a standard deviation of 0.1" in text(
        "unknown", (), variations=(balls,)
    )
    draught = drift.model_copy(update={"kind": "by_side"})
    assert "is larger where y > 0 than where y < 0, by 0.1" in text(
        "unknown", (), variations=(draught,)
    )


def test_a_restitution_that_differs_too_much_is_said_with_what_to_do():
    bounces = Check(name="bounces", ratio=0.06, interval=(0.05, 0.07), allowed=(0.0, 0.03))
    message = text("unknown", (), checks=(bounces,))
    assert "the restitution differs by 0.06 from bounce to bounce (allowed 0.03)" in message
    assert "let one ball bounce at one place" in message
