"""Known answers on measured sets: verdicts on real recordings with errors that are planted."""
