"""Forecasts of measured sets: some recordings adapt predictors, which are tested on the others."""
