"""Scenes of MuJoCo: the ball and the table in them, their flights, and what their files say."""
