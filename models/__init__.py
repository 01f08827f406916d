"""The models of the world. No file of a run, no tracking, no command line."""
