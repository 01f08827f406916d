"""Figures of policies: drawing alone, from tables that others have computed."""
