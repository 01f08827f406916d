"""The quality of returns: how fast, spun and flat they are, and how often such shots win."""
