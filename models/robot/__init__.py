"""The robot: a gantry arm with a racket, moved by Bullet. The ball is not Bullet's."""
