"""The data of the blind exam: recordings of halls with a hidden effect, and their sealed truth."""
