"""Inference: score tests and penalised scores of sets of linearised columns."""
