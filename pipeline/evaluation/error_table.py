"""The errors that evaluate_predictor reports, read by who sets costs beside them."""

from pathlib import Path

import pandas as pd
import pandera.pandas as pa

from pipeline.io.report_manifest import read_rows
from pipeline.io.schemas import checked
from pipeline.runtime.errors import InputError

REPORT = Path("reports") / "evaluate_predictor" / "forecast_error.csv"
NUMBERS = ["mean", "std", "n", "ci_low", "ci_high"]
KEYS = ["set", "against", "predictor", "quantity", "bounce", "horizon_ms"]
WHOLE = ["horizon_ms", "n"]
RUN = "run `dvc repro -f evaluate_predictor`"


def _type(name: str) -> str:
    if name in WHOLE:
        return "Int64"
    return "float" if name in NUMBERS else "string"


# read_rows takes numbers without a point for whole ones, and names of digits for numbers.
ERRORS = pa.DataFrameSchema(
    {name: pa.Column(_type(name), coerce=name not in WHOLE) for name in [*KEYS, *NUMBERS]},
    name="forecast errors",
    description="one row a set, target, predictor, quantity, kind of window and horizon",
)


def read_errors(root: Path) -> pd.DataFrame:
    """Read the report of a repository's last run.

    Raises:
        InputError: it is missing or is no such table, naming the row and column at fault.
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
        raise InputError(path, f"is there twice; {RUN}", row=int(twice.argmax()) + 1)
    return errors
