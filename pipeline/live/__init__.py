"""Live forecasts over a network: measurements come in from a camera server, forecasts go out."""
