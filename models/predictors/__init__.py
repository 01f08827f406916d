"""Predictors: the last 12 ball states in, the next 60 out."""
