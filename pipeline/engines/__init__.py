"""Engines by name or by file, and their audits as files."""
