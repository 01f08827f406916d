"""Name: which numbers of the simulator explain the gap, tested against all others."""
