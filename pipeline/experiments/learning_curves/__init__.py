"""Learning curves: how good predictors are by the number of recordings that they learn from."""
