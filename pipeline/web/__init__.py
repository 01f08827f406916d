"""Offline pages of a run."""
