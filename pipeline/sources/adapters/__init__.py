"""The shipped sources, one file each; the registry finds them here by themselves."""
