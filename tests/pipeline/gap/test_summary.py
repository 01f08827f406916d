"""The verdict in sentences has the numbers that a reader needs first."""

import pytest

from rallygap.models.gap.verdict import Check, NetErrors, Unexplained, Variation
from rallygap.pipeline.gap import summary
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
BOUNCES = Check(name="bounces", ratio=0.06, interval=(0.05, 0.07), allowed=(0.0, 0.03))
DRIFT = Variation(
    identity="drag.cd",
    kind="drift",
    unit="1",
    size=0.1,
    interval=(0.08, 0.12),
    p_value=1e-5,
    possible=("drag.cd", "linear_drag.k1"),
)
REST = Unexplained(share=0.6, p_value=1e-4, phase="table", formula="+0.1 [slip]")


def outcome(*arguments, **changes):
    return findings(verdict(*arguments, **changes)).outcome


def text(*arguments, **changes):
    found = findings(verdict(*arguments, **changes))
    return " ".join([*found.outcome, *found.details])


def has(message, *parts):
    return all(part in message for part in parts)


def test_numbers_that_a_reader_needs_first_are_said():
    message = text("no_gap", ())
    assert has(message, "4 shots of lab", "sim.yaml", "200 ms", "buoyancy.b, spin_decay.c")
    assert has(message, "21.0 mm", "7.0 mm", "3 of 5") and "8.0 mm" not in message
    message = text("ambiguous", (WIND, GRAVITY))
    assert has(message, "0.61 m/s (95 % 0.59 to 0.63)", "70 %", "5.3 mm more (95 % 2.8 to 7.9)")
    assert has(message, "10.3 m/s^2", "9.81", "buoyancy.b", "0.4 mm less (95 % -0.2 to 1.1)")
    assert has(message, "21.0 mm before, 8.0 mm after", "31.0 mm and 4.00 ms before")
    assert has(message, "100 % in flight, 0 % at the table", "speed at launch", "40 %", "p < 0.001")
    assert "Prediction error" not in text(gap=None)


def test_the_outcome_goes_from_errors_over_causes_to_what_to_do():
    errors = NetErrors(contacts=40, held_out=13, horizon_ms=100, before_mm=321.9, after_mm=18.6)
    lines = outcome("named", (WIND, CAMERA, MINOR), unexplained=REST, net=errors)
    parts = ["Named", "7.0 mm", "12.0 mm", "321.9 mm", "wind.x", "camera_distortion", "spin_decay"]
    parts += ["60 %", "+0.1 [slip]", "Next: "]
    assert all(part in line for line, part in zip(lines, parts, strict=True))


@pytest.mark.parametrize(
    ("changes", "sizes", "step"),
    [
        ({"checks": (MISFIT,)}, ["2.2", "1.4 to 3.2", "0.75 to 1.33"], summary.CHECK_RECORDINGS),
        ({"checks": (LABELS_MISFIT,)}, ["62 %", "50 %"], summary.CHECK_LABELS),
        ({"checks": (BOUNCES,)}, ["0.06", "0.03"], summary.CHECK_BOUNCES),
        ({"gap": WORSE}, ["5.0 mm more", "(95 % 2.0 to 9.0)"], summary.KEEP_NOMINAL),
    ],
)
def test_reservations_are_said_first_with_their_sizes(changes, sizes, step):
    first, second, *_, last = outcome(**changes)
    assert has(first, *sizes) and second.startswith("Named: ") and step in last


@pytest.mark.parametrize(
    ("arguments", "changes", "step"),
    [
        (("named",), {}, summary.CONFIRM),
        (("ambiguous", (WIND, GRAVITY)), {}, "to tell gravity.g from buoyancy.b"),
        (("ambiguous", (WIND,)), {}, summary.UNSETTLED),
        (("no_gap", ()), {}, "20 shots"),
        (("unknown", ()), {}, "add-an-effect"),
        (("unknown", ()), {"unexplained": REST}, "an effect at the table"),
        (("unknown", ()), {"variations": (DRIFT,)}, summary.SPLIT),
    ],
)
def test_what_to_do_next_follows_from_the_verdict(arguments, changes, step):
    assert step in outcome(*arguments, **changes)[-1]


def test_each_kind_of_variation_is_said_with_its_size():
    kinds = ("drift", "between_shots", "by_side")
    varied = [DRIFT.model_copy(update={"kind": kind}) for kind in kinds]
    messages = [outcome("unknown", (), variations=(variation,))[3] for variation in varied]
    assert len(set(messages)) == len(kinds)
    assert all(has(message, "drag.cd", "0.1 (95 % 0.08 to 0.12)") for message in messages)
    assert all("linear_drag.k1" in message for message in messages)
