"""From exam records to rates, the same for every method."""
