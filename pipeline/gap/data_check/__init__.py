"""Checks of recordings before any verdict: units, axes, heights and spin labels."""
