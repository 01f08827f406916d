"""Figures of transfer: drawing alone, from tables that others have computed."""
