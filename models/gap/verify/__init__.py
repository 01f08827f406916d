"""Verify: prediction errors before and after, on shots that naming never saw."""
