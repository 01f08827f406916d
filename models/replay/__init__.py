"""Replay: measured balls on their way to the robot, and what policies make of them."""
