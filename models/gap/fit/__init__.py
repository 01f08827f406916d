"""Fit: every shot's launch, label errors and bounce scatter, given a simulator and its sensor."""
