"""Fresh arenas: the gap workflow on worlds that its development has not looked at."""
