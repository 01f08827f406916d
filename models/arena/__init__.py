"""The arena: simulated players, ball cannon, cameras and hidden physics."""
