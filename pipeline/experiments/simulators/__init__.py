"""Scenes of MuJoCo and PyBullet: amended, and written from lists of effects and audited."""
