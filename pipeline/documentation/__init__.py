"""Pages of docs/ that are generated from the code and from runs."""
