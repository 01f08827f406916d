"""The amended simulator beside the one it was and the truth."""

import pandas as pd

from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.amend.simulator import amended
from rallygap.pipeline.transfer.truth_comparison import NamedCauses, number_table
from tests.pipeline.amendments import causes
from tests.pipeline.verdicts import verdict

ORIGINAL = shipped("imperfect_c")
FOUND = verdict(causes=causes("imperfect_c", {"drag": {"cd": 0.5}, "wind": {"x": 0.2}}))
AMENDED = amended(ORIGINAL, FOUND)


def table(truth):
    causes = NamedCauses.model_validate_json(FOUND.to_json()).causes
    rows = number_table(ORIGINAL, AMENDED, causes, truth)
    return rows.set_index(["effect", "parameter"])


def test_found_and_missed_parameters_are_compared_with_the_truth():
    truth = ORIGINAL.amended("drag", cd=0.55).amended("table_bounce", restitution=0.98)
    rows = table(truth.amended("racket_bounce", restitution=0.8))
    assert rows.loc["racket_bounce", "restitution"][["low", "high"]].isna().all()
    drag = rows.loc["drag", "cd"]
    assert drag.tolist() == [0.4, 0.5, 0.49, 0.51, 0.55]
    missed = rows.loc["table_bounce", "restitution"]
    assert missed[["original", "amended", "truth"]].tolist() == [0.9, 0.9, 0.98]
    assert missed[["low", "high"]].isna().all()
    assert ("magnus", "cm") not in rows.index


def test_an_effect_that_a_simulator_lacks_has_no_number_there_and_a_table_of_the_cameras_none():
    rows = table(None)
    assert pd.isna(rows.loc["wind", "x"]["original"])
    assert rows.loc["wind", "x"]["amended"] == 0.2
    assert rows["truth"].isna().all()
    nodes = [[0.0, 0.0, 0.2, 1.0, 0.0, 0.0]]
    camera = {"amplitude": 0.002, "length": 0.7, "nodes": nodes}
    amended = shipped("imperfect_c").amended("camera_distortion", **camera)
    rows = number_table(shipped("imperfect_c"), amended, [], None)
    assert rows["parameter"].tolist() == ["amplitude", "length"]
