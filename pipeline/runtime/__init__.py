"""What every stage runs in: its run, provenance, processes, progress, errors, the terminal."""
