"""The methods that answer the exam: ours, and simpler ones to compare with."""
