"""The policy: incoming balls, goals, the environment it learns in, and how it is judged."""
