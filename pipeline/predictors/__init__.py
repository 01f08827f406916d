"""Predictors on files: training and storage."""
