"""The benchmark: test windows for anyone's predictor, and the scores of its forecasts."""
