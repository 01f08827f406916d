"""Kills and faults that strike a copy of the repository: docs/reliability.md."""
