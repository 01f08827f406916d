"""The exam on files: its runs, records, tables and figures."""
