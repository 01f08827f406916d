"""Fuzzing: every reader meets damaged and hostile files."""
