"""The tables of the benchmark: exported windows, and forecasts to score."""

import pandera.pandas as pa

from rallygap.models.predictors.errors import HORIZONS_MS
from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS, VELOCITY_COLUMNS

LARGEST = 1e6  # m, m/s, rad/s; an error beyond all floats would drop out of the mean
QUANTITIES = {
    "position (m)": POSITION_COLUMNS,
    "velocity (m/s)": VELOCITY_COLUMNS,
    "spin (rad/s)": SPIN_COLUMNS,
}


def _vectors(*quantities: str, note: str, nullable: bool) -> dict[str, pa.Column]:
    """Return three columns a quantity."""
    bounded = pa.Check.in_range(-LARGEST, LARGEST)
    return {
        name: pa.Column(
            float, bounded, nullable=nullable, description=f"{quantity}, {axis} axis{note}"
        )
        for quantity in quantities
        for name, axis in zip(QUANTITIES[quantity], "xyz", strict=True)
    }


def _mask(what: str) -> pa.Column:
    return pa.Column(bool, description=f"whether the {what} was measured at this instant")


WINDOWS = pa.DataFrameSchema(
    {
        "set": pa.Column(str, description="set of measured balls"),
        "window_id": pa.Column(str, description="name of the window; says nothing of its place"),
        "t": pa.Column(float, description="s before the last state, which is at 0"),
        **_vectors("position (m)", "spin (rad/s)", note="; null if not measured", nullable=True),
        "position_measured": _mask("position"),
        "spin_measured": _mask("spin"),
    },
    unique=["window_id", "t"],
    strict=True,
    ordered=True,
    name="windows",
    description="twelve states a window, 5 ms apart, the last one at t = 0; one row a state",
)

FORECASTS = pa.DataFrameSchema(
    {
        "window_id": pa.Column(str, description="name of a window"),
        "horizon_ms": pa.Column(
            int, pa.Check.isin(HORIZONS_MS), description="ms after the window's last state"
        ),
        **_vectors(*QUANTITIES, note=" at that instant", nullable=False),
    },
    strict=True,
    name="forecasts",
    description="one row a window and horizon; every window of a set, every horizon",
)


def type_of(column: pa.Column) -> str:
    """Return the type of a column as it is called everywhere: string, int64, float64 or bool."""
    name = str(column.dtype)
    return "string" if name.startswith("str") else name  # pandas knows strings of many kinds
