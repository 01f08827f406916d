"""Verdict: names, the file's content, and the amended simulator."""

import json

import pytest
import yaml

from models.ball.simulator import Simulator
from models.ball.simulators import shipped
from models.gap.amend.simulator import amended, amended_yaml
from models.gap.diagnose import judged
from models.gap.hypotheses import Hypothesis, hypotheses
from models.gap.verdict import (
    Cause,
    Gap,
    Unexplained,
    Verdict,
    Where,
    component_of,
    label_of,
    name_of,
)
from tests.models.gap.hidden import NOMINAL


def cause(name, parameter, estimate, component=None, kind="missing_effect", nominal=0.0):
    return Cause(
        name=name,
        component=component,
        kind=kind,
        parameter=parameter,
        unit="1",
        nominal=nominal,
        estimate=estimate,
        interval=(estimate - 0.01, estimate + 0.01),
        p_value=1e-4,
        gap_share=0.5,
        **{"class": (name, "drag")},
    )


WIND = cause("wind", "y", 0.3, component="y")
RESTITUTION = cause("restitution", "restitution", 0.9, kind="wrong_value", nominal=0.92)
VERDICT = Verdict(
    verdict="ambiguous",
    effects=(WIND, RESTITUTION),
    unexplained=Unexplained(share=0.0, p_value=0.4),
    where=Where(flight=0.5, table=0.5, sensor=0.0),
    gap=Gap(
        horizons_ms=(100,),
        before_mm=(9.0,),
        after_mm=(5.0,),
        floor_mm=(4.5,),
        removable_closed=0.9,
        interval=(0.8, 1.0),
    ),
    detectable={"drag": 0.01},
    blind_to=("time_offset",),
    limits=("few shots",),
)


@pytest.mark.parametrize(
    ("effect", "parameter", "name", "component", "label"),
    [
        ("wind", "y", "wind", "y", "wind.y"),
        ("drag", "cd", "drag", None, "drag"),
        ("position_scale", "s", "position_scale", None, "position_scale"),
        ("table_bounce", "friction", "friction", None, "friction"),
    ],
)
def test_numbers_are_called_as_people_call_them(effect, parameter, name, component, label):
    one = Hypothesis(effect, parameter)
    assert (name_of(one), component_of(one), label_of(one)) == (name, component, label)


@pytest.mark.parametrize("simulator", ["literature", "imperfect_c"])
def test_no_two_numbers_have_one_name(simulator):
    labels = [label_of(one) for one in hypotheses(shipped(simulator))]
    assert len(labels) == len(set(labels))


def test_what_is_found_of_the_table_is_changed_at_the_table_alone():
    before = shipped("literature")  # its racket has a restitution, too
    after = amended(before, VERDICT.model_copy(update={"effects": (RESTITUTION,)}))
    table = {**before.effects["table_bounce"], "restitution": 0.9}
    assert after.to_dict() == {**before.to_dict(), "table_bounce": table}


def test_the_file_has_the_promised_keys_and_comes_back():
    content = json.loads(VERDICT.to_json())
    assert list(content) == [
        "verdict", "effects", "unexplained", "where", "gap", "detectable", "blind_to",
    ]  # fmt: skip
    assert list(content["effects"][0]) == [
        "name", "component", "kind", "parameter", "unit", "nominal", "estimate", "interval",
        "p_value", "gap_share", "class",
    ]  # fmt: skip
    assert list(content["gap"]) == [
        "horizons_ms", "before_mm", "after_mm", "floor_mm", "removable_closed", "interval",
        "landing", "before_interval_mm", "after_interval_mm", "closer_mm",
    ]  # fmt: skip
    assert Verdict.from_json(VERDICT.to_json()).effects == VERDICT.effects


def test_the_amended_simulator_has_the_estimates():
    simulator = amended(NOMINAL, VERDICT)
    assert simulator.effects["wind"] == {"x": 0.0, "y": 0.3, "z": 0.0}
    assert simulator.effects["table_bounce"] == {"restitution": 0.9, "friction": 0.25}
    assert simulator.effects["drag"] == NOMINAL.effects["drag"]


def test_an_amended_file_is_a_simulator_and_says_where_its_changes_come_from():
    text = amended_yaml(NOMINAL, VERDICT, "my_data")
    assert Simulator.from_dict(yaml.safe_load(text)) == amended(NOMINAL, VERDICT)
    lines = text.splitlines()
    note = lines[lines.index("wind: {x: 0.0, y: 0.3, z: 0.0}") - 1]
    for part in ("was missing", "my_data", "0.3", "0.29", "ambiguous", "could be drag"):
        assert part in note
    assert "was 0.92" in text


def test_estimates_stay_within_what_makes_sense():
    far = VERDICT.model_copy(update={"effects": (cause("spin_decay", "c", -0.1),)})
    assert amended(NOMINAL, far).effects["spin_decay"]["c"] == 0.0


def test_causes_with_which_other_shots_are_predicted_worse_are_no_names():
    worse = VERDICT.gap.model_copy(update={"after_mm": (11.0,), "closer_mm": (-3.0, -1.0)})
    verdict = judged(VERDICT, worse)
    assert verdict.verdict == "unknown"
    assert verdict.effects == VERDICT.effects
    assert "11.0 mm and not 9.0 mm" in verdict.limits[-1]
    assert amended(NOMINAL, verdict) == NOMINAL
    assert Simulator.from_dict(yaml.safe_load(amended_yaml(NOMINAL, verdict, "my_data"))) == NOMINAL


@pytest.mark.parametrize("closer", [(-1.0, 3.0), (1.0, 3.0), None])
def test_other_shots_leave_names_that_do_not_mislead(closer):
    fair = VERDICT.gap.model_copy(update={"closer_mm": closer})
    assert judged(VERDICT, fair) == VERDICT.model_copy(update={"gap": fair})
