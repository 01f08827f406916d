"""Training and storage of policies."""
