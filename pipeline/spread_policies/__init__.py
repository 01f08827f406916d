"""Policies that observe how sure forecasts are, compared with policies that do not."""
