"""Amateur and club launches beside the public ones."""

import json

import numpy as np
import pytest
from scipy.stats import ks_2samp

from tests.models.arena.sessions import games

KEYS = [f"{part}_{axis}" for part in ("pos", "vel", "w_vel") for axis in "xyz"]

# A ball that flies as the public ones do rises to 0.36 m (median) after its bounce, but public
# strokes are met at 0.42 m: in a game that feeds itself, contacts must be lower than those, and
# who strikes a lower ball must strike it more upwards.
BOUNDS = {
    "rallies": {"speed": 0.2, "height": 0.4, "elevation": 0.4, "azimuth": 0.2, "spin": 0.2},
    "serves": {"speed": 0.2, "height": 0.2, "elevation": 0.2, "azimuth": 0.2, "spin": 0.2},
}


def quantities(states):
    """Return what (B, 9) launches look like to those who strike them."""
    way = np.sign(states[:, 4:5])
    speed = np.linalg.norm(states[:, 3:6], axis=1)
    ahead = states[:, 3:5] * way
    return {
        "speed": speed,
        "height": states[:, 2],
        "elevation": np.arcsin(states[:, 5] / speed),
        "azimuth": np.arctan2(ahead[:, 0], ahead[:, 1]),
        "spin": np.linalg.norm(states[:, 6:], axis=1),
    }


def arena_launches():
    """Return launches of amateurs and club players, of serves and of all other strokes."""
    launches = {"serves": [], "rallies": []}
    for game in games():
        if game.name.split("/")[0] in ("amateur", "club"):
            toss = np.append(False, game.contacts.kinds[:-1] == "launch")
            struck = game.contacts.kinds == "racket"
            launches["serves"].append(game.contacts.states[struck & toss])
            launches["rallies"].append(game.contacts.states[struck & ~toss])
    return {name: np.concatenate(parts) for name, parts in launches.items()}


@pytest.mark.real
@pytest.mark.parametrize("name", ["rallies", "serves"])
def test_launches_are_distributed_like_the_public_ones(real_data, name):
    path = real_data / "competitive_robot_table_tennis" / f"{name}.json"
    public = np.array([[entry[key] for key in KEYS] for entry in json.loads(path.read_text())])
    ours, theirs = quantities(arena_launches()[name]), quantities(public)

    for quantity, bound in BOUNDS[name].items():
        assert ks_2samp(ours[quantity], theirs[quantity]).statistic < bound, quantity
