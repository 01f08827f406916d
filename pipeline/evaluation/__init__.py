"""Evaluation of predictors: who forecasts, on which windows, how far off and at what cost."""
