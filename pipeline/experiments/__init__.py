"""DVC experiments: profiles, results that are kept, and repairs of the cache."""
