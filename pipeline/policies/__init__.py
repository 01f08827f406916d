"""Training, storage and reports of policies."""
