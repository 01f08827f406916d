"""The benchmark: test windows for anyone's predictor, and its forecasts' scores beside ours."""
