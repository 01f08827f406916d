"""Scenes of MuJoCo and PyBullet: wrong ones are amended, and lists go into one and come back."""
