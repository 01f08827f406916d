"""When swapping the predictor of a policy helps: protocols, ages of forecasts, latency, labels."""
