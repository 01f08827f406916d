"""Hyperparameter sweeps with Optuna: settings, study, training, comparison, report, confirm."""
