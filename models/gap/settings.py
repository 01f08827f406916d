"""Settings of the gap workflow."""
