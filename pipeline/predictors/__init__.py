"""Training, storage and reports of learned predictors."""
