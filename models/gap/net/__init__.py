"""Net: its restitution and friction, by the shots that touch it."""
