"""Launches of simulated players and measured ones, in the same columns."""

import numpy as np
import pandas as pd

from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS, VELOCITY_COLUMNS

QUANTITIES = {
    "speed": "m/s",
    "height": "m",
    "elevation": "degrees",
    "direction": "degrees",
    "spin": "rad/s",
}
STROKES = {"rallies": "rally", "serves": "serve"}  # sets of measured launches

MEASURED = "measured"


def simulated_launches(contacts: pd.DataFrame) -> pd.DataFrame:
    """Return what strokes and cannon make of the ball in simulated recordings.

    Args:
        contacts: what the contract ``TRUE_CONTACTS`` says. A racket contact right after a launch,
            the toss, is a serve.

    Returns:
        Columns group (the second part of the recording's id), stroke (cannon, serve or rally) and
        ``QUANTITIES``.
    """
    group = contacts["recording_id"].str.split("/").str[1]
    tossed = (contacts["kind"] == "launch").shift(fill_value=False)
    stroke = pd.Series("rally", index=contacts.index).mask(tossed, "serve")
    by_cannon = (contacts["kind"] == "launch") & (group == "cannon")
    chosen = by_cannon | (contacts["kind"] == "racket")
    named = {"group": group, "stroke": stroke.mask(by_cannon, "cannon")}
    return pd.DataFrame({**named, **_quantities(contacts)})[chosen].reset_index(drop=True)


def measured_launches(launches: pd.DataFrame) -> pd.DataFrame:
    """Return measured strokes in the columns of ``simulated_launches``.

    Args:
        launches: what the contract ``LAUNCHES`` says.
    """
    stroke = launches["launch_id"].str.split("/").str[1].map(STROKES)
    return pd.DataFrame({"group": MEASURED, "stroke": stroke, **_quantities(launches)})


def _quantities(states: pd.DataFrame) -> dict[str, pd.Series]:
    position, velocity, spin = (
        states[columns].to_numpy() for columns in (POSITION_COLUMNS, VELOCITY_COLUMNS, SPIN_COLUMNS)
    )
    x, y, z = velocity.T
    values = {
        "speed": np.linalg.norm(velocity, axis=1),
        "height": position[:, 2],
        "elevation": np.degrees(np.arctan2(z, np.hypot(x, y))),
        # From straight along the table, to the right of the player who hits the ball.
        "direction": np.degrees(np.arctan2(np.sign(y) * x, np.abs(y))),
        "spin": np.linalg.norm(spin, axis=1),
    }
    return {name: pd.Series(value, index=states.index) for name, value in values.items()}
