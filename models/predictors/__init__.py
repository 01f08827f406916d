"""Predictors: from the last 12 measured ball states to the next 60."""
