"""Offline pages and the PDF of a run."""
