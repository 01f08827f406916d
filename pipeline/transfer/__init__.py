"""Transfer: policies in another simulator and on replayed balls, and retrained ones."""
