"""The gap between simulation and measurement: where it is, what causes it, and without it."""
