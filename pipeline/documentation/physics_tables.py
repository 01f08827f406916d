"""Constants and quantities of the ball as Markdown tables, read from the code."""

from models.ball import state
from models.ball.quantities import QUANTITIES
from pipeline.io.markdown import markdown_table

# Name in models/ball/state.py: symbol, meaning, unit, source.
CONSTANTS = {
    "BALL_MASS": ("m", "mass of the ball", "kg", "ITTF Law 2.3"),
    "BALL_RADIUS": ("r", "radius of the ball", "m", "ITTF Law 2.3"),
    "BALL_AREA": ("A", "cross-section of the ball", "m²", "π r²"),
    "BALL_VOLUME": ("V", "volume of the ball", "m³", "4/3 π r³"),
    "AIR_DENSITY": ("ρ", "density of air", "kg/m³", "20 °C, 1013 hPa"),
    "DRAG_FACTOR": ("k_D / C_D", "factor of drag, ρ A / 2m", "1/m", "Nakashima 2010"),
    "MAGNUS_FACTOR": ("k_M / C_M", "factor of lift, ρ V / m", "1", "Nakashima 2010"),
    "TABLE_HALF_LENGTH": ("", "half of the table's length, along y", "m", "ITTF Law 2.1"),
    "TABLE_HALF_WIDTH": ("", "half of the table's width, along x", "m", "ITTF Law 2.1"),
    "NET_HEIGHT": ("", "height of the net", "m", "ITTF Law 2.2"),
    "NET_OVERHANG": ("", "length of the net beyond each side line", "m", "ITTF Law 2.2"),
}


def constants_table() -> str:
    """Return the constants with symbol, value, unit and source."""
    rows = [
        [f"`{name}`", symbol, meaning, f"{getattr(state, name):.6g}", unit, source]
        for name, (symbol, meaning, unit, source) in CONSTANTS.items()
    ]
    return markdown_table(["name", "symbol", "meaning", "value", "unit", "source"], rows)


def quantities_table() -> str:
    """Return the quantities that effects change, as a Markdown table."""
    rows = [
        [f"`{one.name}`", one.acts, one.meaning, f"{one.start:g}", str(one.size)]
        for one in QUANTITIES
    ]
    return markdown_table(["quantity", "acts in", "meaning", "start", "components"], rows)
