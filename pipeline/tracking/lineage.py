"""Addresses of MLflow's pages."""

import sqlite3
from contextlib import closing
from pathlib import Path

from rallygap.pipeline.tracking.recording import EXPERIMENT


def runs_page(root: Path, server: str) -> str:
    """The address of the list of a repository's runs, or of the first page where there are none."""
    query = "SELECT experiment_id FROM experiments WHERE name = ?"
    try:
        with closing(sqlite3.connect(f"file:{root / 'mlflow.db'}?mode=ro", uri=True)) as store:
            row = store.execute(query, (EXPERIMENT,)).fetchone()
    except sqlite3.Error:
        row = None
    return f"{server.rstrip('/')}/#/experiments/{row[0]}/runs" if row else server
