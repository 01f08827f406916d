"""Sweeps: settings tried out by Optuna, and what comes of it confirmed on balls it never saw."""
