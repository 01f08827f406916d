"""The recordings of a question, by an independent ball with laws of its own."""
