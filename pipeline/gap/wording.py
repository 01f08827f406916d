"""Wording: numbers, causes and places as people read them."""

from models.gap.verdict import Cause

PLACES = {"flight": "in flight", "table": "at the table", "sensor": "in the measurement"}


def label(cause: Cause) -> str:
    """Return how a cause is called, such as ``wind.x``."""
    return f"{cause.name}.{cause.component}" if cause.component else cause.name


def number(value: float) -> str:
    """Return a number with the digits worth reading."""
    return f"{value:.4g}"


def with_unit(value: float, unit: str) -> str:
    """Return a number with its unit, if it has one."""
    return number(value) if unit == "1" else f"{number(value)} {unit}"


def percent(share: float) -> str:
    """Return a share as people read it."""
    return f"{100 * share:.0f} %"


def chance(p_value: float) -> str:
    """Return the chance of an axis as people write it."""
    return "p below 0.001" if p_value < 1e-3 else f"p = {p_value:.2g}"
