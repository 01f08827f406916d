"""Find where a ball simulator and measured trajectories disagree, and name the missing effect."""
