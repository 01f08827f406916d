"""The models of the world. No files, no tracking, no command line."""
