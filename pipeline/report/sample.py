"""What return rates in a figure are means of, in words."""

import pandas as pd


def sample(rates: pd.DataFrame) -> str:
    """Return such as ``300 shots, 2 trainings``.

    Args:
        rates: with columns ``balls``, the same in all rows, and ``trainings``.
    """
    return f"{rates['balls'].iloc[0]:,} shots, {trainings(rates)}"


def trainings(rates: pd.DataFrame) -> str:
    """Return such as ``2 trainings``.

    Args:
        rates: with the column ``trainings``, the same in all rows.
    """
    count = rates["trainings"].iloc[0]
    return f"{count} training{'s' if count > 1 else ''}"
