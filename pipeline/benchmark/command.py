"""``rallygap benchmark``: exports test windows and scores forecasts of them."""

from pathlib import Path
from typing import Annotated

import typer

from rallygap.pipeline.runtime.console import show
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.paths import check_file, check_folder, clone_with_run

app = typer.Typer(no_args_is_help=True, help="Test windows for any predictor, and its scores.")


@app.command()
def export(folder: Annotated[Path, typer.Argument(help="the folder to write to")]) -> None:
    """Write test windows of the last run, one per episode, without their futures, into FOLDER."""
    from rallygap.pipeline.benchmark.windows import export_windows, run_sets
    from rallygap.pipeline.params import load_params

    root = clone_with_run()
    check_folder(folder)
    sets = run_sets(root, load_params(root / "params.yaml"))
    export_windows(sets, folder)
    counts = ", ".join(f"{len(measured.windows):,} of {measured.name}" for measured in sets)
    typer.echo(f"Windows: {counts}. What to do with them: {folder / 'README.md'}")


@app.command()
def score(
    forecasts: Annotated[
        Path, typer.Argument(help="parquet, in the format that README.md in the export describes")
    ],
    out: Annotated[Path | None, typer.Option(help="a JSON file: scores at all horizons")] = None,
) -> None:
    """Score FORECASTS of the last run's test windows, and its own predictors on the same."""
    from rallygap.pipeline.benchmark.scores import score as score_forecasts
    from rallygap.pipeline.benchmark.scores import score_tables, write_scores
    from rallygap.pipeline.params import load_params

    root = clone_with_run()
    if out is not None:
        check_file(out)
        if out.resolve() == forecasts.resolve():
            raise InputError(out, "is the file of the forecasts; give another one to --out")
    scores = score_forecasts(root, load_params(root / "params.yaml"), forecasts)
    for table in score_tables(scores, own=forecasts.name):
        show(table)
        typer.echo()
    if out is not None:
        write_scores(out, scores)
        typer.echo(f"All horizons: {out}")
