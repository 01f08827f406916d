"""When exchanging the predictor of a policy pays: protocols, ages of forecasts, latency, labels."""
