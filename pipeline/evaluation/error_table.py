"""Reads the error table of evaluate_predictor, with its schema."""

from pathlib import Path

import pandas as pd
import pandera.pandas as pa

from rallygap.pipeline.io.schemas import checked
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.web.pages import read_rows

REPORT = Path("reports") / "evaluate_predictor" / "forecast_error.csv"
NUMBERS = ["mean", "median", "std", "n", "ci_low", "ci_high"]
KEYS = ["set", "against", "predictor", "quantity", "bounce", "horizon_ms"]
WHOLE = ["horizon_ms", "n"]
RUN = "run `dvc repro -f evaluate_predictor`"


def _type(name: str) -> str:
    if name in WHOLE:
        return "Int64"
    return "float" if name in NUMBERS else "string"


# read_rows infers types from the text: integers without a point, digits in names as numbers.
ERRORS = pa.DataFrameSchema(
    {name: pa.Column(_type(name), coerce=name not in WHOLE) for name in [*KEYS, *NUMBERS]},
    name="forecast errors",
    description="one row a set, target, predictor, quantity, kind of window and horizon",
)


def read_errors(root: Path) -> pd.DataFrame:
    """Read the error table of a repository's last run.

    Raises:
        InputError: it is missing or invalid; the error names row and column.
    """
    path = root / REPORT
    if not path.is_file():
        raise InputError(path, "there is no such file; run `dvc repro evaluate_predictor`")
    rows = read_rows(path)
    try:
        errors = checked(rows, ERRORS).astype(dict.fromkeys(WHOLE, int))
    except InputError as error:
        raise InputError(
            path, f"{error.problem}; {RUN}", row=error.row, field=error.field
        ) from None
    twice = errors.duplicated(KEYS).to_numpy()
    if twice.any():
        raise InputError(path, f"is a duplicate; {RUN}", row=int(twice.argmax()) + 1)
    return errors
