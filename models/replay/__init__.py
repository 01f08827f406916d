"""Replay of measured shots to policies."""
