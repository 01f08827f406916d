"""Drawing: figures, tables and the report page."""
