"""Shared by all models: cached compilation, discovery of plugins, hints for unknown names."""
