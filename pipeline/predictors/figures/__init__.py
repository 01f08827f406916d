"""Figures of predictors: drawing alone, from tables that others have computed."""
