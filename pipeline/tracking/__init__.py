"""MLflow: runs of stages, registered models, and the way from a file back to its run."""
