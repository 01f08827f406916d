"""MLflow: a run for each stage and trial, live metrics of trainings, and registered models."""
