"""The outputs of a stage, read back."""

import pandas as pd

from rallygap.pipeline.report.stages import write_report


def items(run):
    """What the stage ``report`` writes of a stage: kinds, files, titles and captions."""
    return write_report(run, run.stage)


def table(run, name, *keys):
    """A table of the report, indexed by ``keys``."""
    items(run)
    rows = pd.read_csv(run.report(f"{name}.csv"))
    return rows.set_index(list(keys)) if keys else rows


def written(run):
    """The content of every file of a stage's artefacts and report, by path."""
    folders = (run.artifact("."), run.report("."))
    files = (path for folder in folders for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(run.root)): path.read_bytes() for path in files}
