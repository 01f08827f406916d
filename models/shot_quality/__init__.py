"""Quality of returns: features, winning probability and its cross-validation."""
