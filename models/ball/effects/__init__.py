"""The effects, one module each. A new module is found without registration."""
