"""How balls leave rackets: what counts as which stroke, its numbers and their figure."""

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS, VELOCITY_COLUMNS
from rallygap.pipeline.report.launches import launch_distributions, launches_figure
from rallygap.pipeline.sources.launches import measured_launches, simulated_launches

STATE_COLUMNS = [*POSITION_COLUMNS, *VELOCITY_COLUMNS, *SPIN_COLUMNS]


def true_contacts(*rows):
    """A table of (recording_id, kind), with one state for all."""
    table = pd.DataFrame(list(rows), columns=["recording_id", "kind"])
    return table.assign(t=range(len(rows)), **dict.fromkeys(STATE_COLUMNS, 1.0))


def launches(**values):
    """One measured rally stroke: at rest in the origin but for ``values``."""
    state = {**dict.fromkeys(STATE_COLUMNS, 0.0), **values}
    return pd.DataFrame([{"launch_id": "robot/rallies/1", **state}])


def made_up(stroke, random, **shifts):
    """Launches of some groups, their quantities normally distributed about a shift."""
    return pd.concat(
        pd.DataFrame(random.normal(shift, 1.0, (400, 5)), columns=NAMES).assign(
            group=group, stroke=stroke
        )
        for group, shift in shifts.items()
    )


NAMES = ["speed", "height", "elevation", "direction", "spin"]


def test_a_stroke_after_the_toss_is_a_serve_and_the_others_are_the_rally_s():
    contacts = true_contacts(
        ("arena/cannon/0", "launch"),
        ("arena/cannon/0", "table"),
        ("arena/club/0", "launch"),
        ("arena/club/0", "racket"),
        ("arena/club/0", "table"),
        ("arena/club/0", "racket"),
        ("arena/club/0", "floor"),
    )

    found = simulated_launches(contacts)

    assert found[["group", "stroke"]].to_numpy().tolist() == [
        ["cannon", "cannon"],
        ["club", "serve"],
        ["club", "rally"],
    ]


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


def test_measured_serves_are_separated_from_rallies():
    both = pd.concat([launches(), launches().assign(launch_id="robot/serves/1")])

    assert measured_launches(both)["stroke"].tolist() == ["rally", "serve"]


def test_quantiles_and_distance_are_those_of_the_distributions():
    random = np.random.default_rng(0)
    drawn = made_up("rally", random, measured=0.0, amateur=0.0, club=0.0, pro=10.0)

    table = launch_distributions(drawn).set_index(["quantity", "group"])

    speed = table.loc["speed (m/s)"]
    assert speed.loc["pro", "50%"] == pytest.approx(10.0, abs=0.2)
    assert speed.loc["pro", "95%"] == pytest.approx(10 + 1.645, abs=0.3)
    assert speed.loc["pro", "distance to measured"] == pytest.approx(1.0, abs=0.01)
    assert speed.loc["amateur and club", "distance to measured"] < 0.1
    assert speed.loc["amateur and club", "launches"] == 800
    assert np.isnan(speed.loc["measured", "distance to measured"])


def test_strokes_are_compared_with_strokes_of_their_kind_only():
    random = np.random.default_rng(0)
    drawn = pd.concat([made_up("serve", random, club=0.0), made_up("rally", random, measured=0.0)])

    assert launch_distributions(drawn)["distance to measured"].isna().all()


def test_a_kind_of_stroke_that_nobody_played_has_no_panels():
    drawn = made_up("serve", np.random.default_rng(0), club=0.0)

    figure = launches_figure(drawn)

    first = figure.axes[0]
    assert first.get_title(loc="left") + first.get_title() == "serves"
    assert len(figure.axes) == len(NAMES)
