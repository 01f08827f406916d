"""The ball: its state, the catalogue of effects and the simulator that is a list of them."""
