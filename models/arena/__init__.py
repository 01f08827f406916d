"""The arena: what stands around the table, simulated."""
