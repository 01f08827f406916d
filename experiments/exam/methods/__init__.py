"""The methods that answer the exam. They never import what knows the truth of a trial."""
