"""Training, storage and model cards of learned predictors."""
