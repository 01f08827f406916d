"""The table, the net and the ball, in the form that the scripts of 3-D views read."""

from rallygap.models.ball import state


def table_geometry() -> dict[str, float]:
    """Return lengths in m, by name."""
    return {
        "half_width": state.TABLE_HALF_WIDTH,
        "half_length": state.TABLE_HALF_LENGTH,
        "net_height": state.NET_HEIGHT,
        "net_overhang": state.NET_OVERHANG,
        "ball_radius": state.BALL_RADIUS,
    }
