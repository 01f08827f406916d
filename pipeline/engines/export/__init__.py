"""Simulators as code for other engines: one short file without dependencies."""
