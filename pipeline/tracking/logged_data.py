"""Metrics and data sets of a stage in MLflow's terms."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mlflow.entities import Dataset, DatasetInput, Metric
from pyarrow.parquet import read_schema

from pipeline.tracking.changed_params import flat
from pipeline.tracking.recording import InputData

# From Arrow's names to MLflow's; a column of any other type is shown as text.
COLUMN_TYPES = {"double": "double", "float": "float", "int64": "long", "bool": "boolean"}


def metric_points(metrics: dict[str, Any], timestamp: int) -> Iterator[Metric]:
    """The numbers among nested metrics; a level of whole numbers becomes MLflow's step.

    ``{"position": {"100": {"mean": 3.0}}}`` is ``position/mean`` at step 100, and MLflow draws
    the error over the horizon.
    """
    for keys, value in flat(metrics):
        if isinstance(value, int | float):
            steps = [int(key) for key in keys if key.isdecimal()]
            name = "/".join(key for key in keys if not key.isdecimal())
            yield Metric(name, value, timestamp, steps[-1] if steps else 0)


def data_set(data: InputData) -> DatasetInput:
    """An input data set as MLflow shows it; ``mlflow.data.get_source`` finds the file again."""
    profile = json.dumps({"num_rows": data.rows})
    source = json.dumps({"uri": data.source})
    schema = columns(Path(data.source))
    return DatasetInput(Dataset(data.name, data.digest, "local", source, schema, profile))


def columns(table: Path) -> str | None:
    """The columns of a parquet file in MLflow's terms; None for what is no table."""
    if table.suffix != ".parquet" or not table.is_file():
        return None
    described = [
        {"type": COLUMN_TYPES.get(str(one.type), "string"), "name": one.name}
        for one in read_schema(table)
    ]
    return json.dumps({"mlflow_colspec": described})
