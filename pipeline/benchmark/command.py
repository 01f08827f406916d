"""``rallygap benchmark``: test windows to take away, forecasts to bring back."""

from pathlib import Path
from typing import Annotated

import typer

from pipeline.provenance import repository_root

app = typer.Typer(no_args_is_help=True, help="Test windows for any predictor, and its scores.")


@app.command()
def export(folder: Annotated[Path, typer.Argument(help="the folder to write to")]) -> None:
    """Write test windows of the last run, one a flight, without their futures, into FOLDER."""
    from pipeline.benchmark.windows import export_windows, run_sets
    from pipeline.params import load_params

    root = repository_root()
    sets = run_sets(root, load_params(root / "params.yaml"))
    export_windows(sets, folder)
    counts = ", ".join(f"{len(one.windows):,} of {one.name}" for one in sets)
    typer.echo(f"Windows: {counts}. What to do with them: {folder / 'README.md'}")


@app.command()
def score(
    forecasts: Annotated[Path, typer.Argument(help="a parquet file as the README asks for")],
    out: Annotated[Path | None, typer.Option(help="a JSON file to write")] = None,
) -> None:
    """Score FORECASTS of the last run's test windows, and its own predictors on the same."""
    from rich.console import Console

    from pipeline.benchmark.scores import score as score_forecasts
    from pipeline.benchmark.scores import score_tables, write_scores
    from pipeline.params import load_params

    root = repository_root()
    scores = score_forecasts(root, load_params(root / "params.yaml"), forecasts)
    for table in score_tables(scores):
        Console().print(table)
        typer.echo()
    if out is not None:
        write_scores(out, scores)
