"""The results page as a printed document."""
