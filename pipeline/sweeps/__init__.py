"""Hyperparameter sweeps with Optuna: settings, study, trial, worker, report, confirm."""
