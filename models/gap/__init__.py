"""The gap between simulation and measurement: its location, its causes, its amendment."""
