"""Evaluation of predictors: test windows, forecasts, errors and coverage."""
