"""Policies on files: training and storage."""
