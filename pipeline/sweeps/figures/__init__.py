"""Figures of sweeps: drawing alone, from tables that others have computed."""
