"""Scenes of MuJoCo amended: the file with a list of effects in its attributes, and verified."""
