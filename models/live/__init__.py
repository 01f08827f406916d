"""Live forecasts: measurements of a ball come in one at a time, forecasts are there at any time."""
