"""The view of live forecasts: a web page of this machine that shows the ball in 3-D."""
