"""Figures and tables of recordings: measured balls, strokes of players, and their contacts."""

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS, VELOCITY_COLUMNS
from rallygap.pipeline.report.ingest import launch_distributions, launches_figure
from rallygap.pipeline.report.segment import LARGEST_ERROR, contact_scores_figure
from rallygap.pipeline.sources.launches import QUANTITIES, measured_launches, simulated_launches

STATE_COLUMNS = [*POSITION_COLUMNS, *VELOCITY_COLUMNS, *SPIN_COLUMNS]


def launches(**values):
    """One measured rally stroke: at rest in the origin but for ``values``."""
    state = {**dict.fromkeys(STATE_COLUMNS, 0.0), **values}
    return pd.DataFrame([{"launch_id": "robot/rallies/1", **state}])


def made_up(stroke, **shifts):
    """Launches of some groups, their quantities normally distributed about a shift."""
    means = np.repeat(list(shifts.values()), 400)[:, None]
    values = np.random.default_rng(0).normal(means, 1.0, (len(means), 5))
    table = pd.DataFrame(values, columns=list(QUANTITIES))
    return table.assign(group=np.repeat(list(shifts), 400), stroke=stroke)


def test_a_stroke_after_the_toss_is_a_serve_and_the_others_are_the_rally_s():
    kinds = ["launch", "table", "launch", "racket", "table", "racket", "floor"]
    contacts = pd.DataFrame({"kind": kinds, **dict.fromkeys(STATE_COLUMNS, 1.0)})
    contacts = contacts.assign(t=contacts.index, recording_id="arena/club/0")
    contacts.loc[:1, "recording_id"] = "arena/cannon/0"
    found = simulated_launches(contacts)[["group", "stroke"]].to_numpy().tolist()
    assert found == [["cannon", "cannon"], ["club", "serve"], ["club", "rally"]]
    both = pd.concat([launches(), launches().assign(launch_id="robot/serves/1")])
    assert measured_launches(both)["stroke"].tolist() == ["rally", "serve"]


@pytest.mark.parametrize(
    ("state", "quantity", "value"),
    [
        ({"vx": 3.0, "vy": -4.0}, "speed", 5.0),
        ({"pz": 0.3}, "height", 0.3),
        ({"vy": -1.0, "vz": 1.0}, "elevation", 45.0),
        ({"vy": 1.0, "vz": -1.0}, "elevation", -45.0),
        ({"vx": 1.0, "vy": 1.0}, "direction", 45.0),
        ({"vx": 1.0, "vy": -1.0}, "direction", -45.0),
        ({"wx": 20.0, "wz": -15.0}, "spin", 25.0),
    ],
)
def test_a_quantity_is_what_its_name_says(state, quantity, value):
    assert measured_launches(launches(**state))[quantity].item() == pytest.approx(value)


def test_quantiles_and_distance_are_those_of_the_distributions():
    drawn = made_up("rally", measured=0.0, amateur=0.0, club=0.0, pro=10.0)
    speed = launch_distributions(drawn).set_index(["quantity", "group"]).loc["speed (m/s)"]
    assert speed.loc["pro", "50%"] == pytest.approx(10.0, abs=0.2)
    assert speed.loc["pro", "95%"] == pytest.approx(10 + 1.645, abs=0.3)
    assert speed.loc["pro", "distance to measured"] == pytest.approx(1.0, abs=0.01)
    assert speed.loc["amateur and club", "distance to measured"] < 0.1
    assert speed.loc["amateur and club", "launches"] == 800
    assert np.isnan(speed.loc["measured", "distance to measured"])


def test_strokes_are_compared_with_those_of_their_kind_and_a_kind_without_any_has_no_panels():
    serves, rallies = made_up("serve", club=0.0), made_up("rally", measured=0.0)
    distances = launch_distributions(pd.concat([serves, rallies]))["distance to measured"]
    assert distances.isna().all()
    assert len(launches_figure(serves).axes) == len(QUANTITIES)


def test_contacts_are_drawn_at_their_speed_in_milliseconds_and_missed_ones_are_crosses():
    columns = {
        "kind": ["table", "table", "racket", "racket"],
        "speed": [1.0, 2.0, 8.0, 20.0],
        "detected": [True, False, True, True],
        "error": [0.001, np.nan, -0.002, 0.0],
    }
    contacts = pd.DataFrame(columns)
    lines = contact_scores_figure(contacts).figure.axes[1].lines
    drawn = {line.get_label(): line.get_xydata() for line in lines}
    np.testing.assert_allclose(drawn["racket: speed after it"], [[8, -2], [20, 0]])
    crosses = [line.get_xydata() for line in lines if line.get_marker() == "x"]
    np.testing.assert_allclose(np.concatenate(crosses), [[2.0, -LARGEST_ERROR]])
    assert not contact_scores_figure(contacts.iloc[:0]).figure.axes[1].lines
