"""Amend: the simulator with the named causes, and where each value comes from."""
