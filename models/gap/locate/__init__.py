"""Locate: how far simulated and measured balls diverge, and in which phase that arises."""
