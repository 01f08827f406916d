"""Fuzzing: every reader meets thousands of damaged and hostile files.

``python -m tests.fuzz`` writes ``reports/reliability/fuzz.csv``; its inputs follow from their
numbers alone.
"""
