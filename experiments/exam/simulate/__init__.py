"""Trials and their simulated recordings, by the catalogue's or by independent dynamics."""
