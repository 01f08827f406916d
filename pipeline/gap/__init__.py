"""The gap workflow on files: shots in, a verdict with its tables, figures and page out."""
