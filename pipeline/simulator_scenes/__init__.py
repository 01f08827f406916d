"""Scenes of MuJoCo and PyBullet with something wrong, diagnosed and amended."""
