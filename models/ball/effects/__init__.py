"""The catalogue: one file an effect. A file put here is found by itself."""
