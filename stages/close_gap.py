"""Close the gap: compare measured balls with simulators, name the causes, amend the simulators."""

from collections.abc import Sequence
from typing import Any

from models.gap.amend.simulator import amended_yaml
from models.gap.diagnose import HELD_OUT
from pipeline.gap.cases import Diagnosed, cases, diagnose_all
from pipeline.gap.figures.stability import closing_figure, stability_figure
from pipeline.gap.shots import read_training_shots
from pipeline.gap.tables import (
    CASE,
    cause_table,
    error_table,
    stability_table,
    verdict_table,
)
from pipeline.io.artifacts import write_text
from pipeline.io.episodes import MeasuredEpisode
from pipeline.io.metrics import place, rounded
from pipeline.runtime.console import warn
from pipeline.runtime.errors import InputError
from pipeline.runtime.stage_run import StageRun, run_stage


def close_gap(run: StageRun) -> None:
    """Diagnose the training balls of every source with every simulator, several times."""
    shots = _enough(run, read_training_shots(run.root / "artifacts"))
    found = diagnose_all(list(cases(shots, run.params.close_gap, run.seed)))
    for one in found:
        _write(run, one)
    _report(run, found)


def _enough(
    run: StageRun, shots: dict[str, list[MeasuredEpisode]]
) -> dict[str, list[MeasuredEpisode]]:
    """Return the sources with shots enough for a verdict; warn of the others."""
    for source, members in shots.items():
        run.log_input(source, run.input("segment", "samples.parquet"), len(members))
        if len(members) < HELD_OUT:
            warn(f"{source} has {len(members)} unbroken shots to learn from; give {HELD_OUT}")
    enough = {source: members for source, members in shots.items() if len(members) >= HELD_OUT}
    if not enough:
        problem = f"no source has {HELD_OUT} unbroken shots of more than twelve samples in train"
        raise InputError(run.input("segment", "episodes.parquet"), problem)
    return enough


def _write(run: StageRun, one: Diagnosed) -> None:
    case = one.case
    amended = amended_yaml(case.simulator, one.verdict, case.source)
    write_text(run.artifact(f"{case.name}.yaml"), amended)
    write_text(run.artifact(f"{case.name}.json"), one.verdict.to_json())


def _report(run: StageRun, found: Sequence[Diagnosed]) -> None:
    run.write_metrics(_metrics(found))
    _add_figures(run, found)
    run.add_table(
        verdict_table(found),
        "verdicts",
        title="Verdicts on training balls",
        caption=f"{_experiment(run)} Causes with their 95 % intervals; where data cannot tell a "
        "cause from others, these follow after `or`. unexplained: share of all that is wrong. "
        "removable_closed: share of the gap between the simulator's errors and their floor that "
        "closed on shots that naming never saw, with its 95 % interval bootstrapped over shots. "
        "closer: by how much errors fell, their mean over horizons, as such an interval. "
        "landing: root mean square error of where these shots meet the table.",
    )
    run.add_table(
        stability_table(found),
        "stability",
        title="Verdicts over splits",
        caption=f"{_experiment(run)} found: in how many of the splits; estimate: their mean, with "
        "the lowest and the highest.",
    )
    run.add_table(
        cause_table(found),
        "causes",
        title="Causes of the gap",
        caption="estimate with its 95 % interval (low, high); p_value: chance that the largest of "
        "all hypotheses looks as large without any gap; gap_share: of all that is wrong; possible: "
        "the names that these shots cannot tell from it, its own first.",
    )
    run.add_table(
        error_table(found),
        "errors",
        title="Errors of predictions before and after",
        caption="Root mean square distance to measured positions, on shots that naming never saw, "
        "each predicted from its first twelve samples. low and high: 95 % by bootstrap over "
        "shots. floor_mm: of a simulator without fault, by launch, scatter and sensor as found.",
    )


def _experiment(run: StageRun) -> str:
    settings = run.params.close_gap
    return (
        f"At most {settings.shots} training shots of a source, drawn at random: two in three "
        f"for naming, the rest for verifying; {settings.splits} times anew."
    )


def _add_figures(run: StageRun, found: Sequence[Diagnosed]) -> None:
    for source in dict.fromkeys(one.case.source for one in found):
        own = [one for one in found if one.case.source == source]
        run.add_figure(
            closing_figure(own),
            f"errors_{source}",
            title=f"How far the gap to {source} closes",
            caption="Root mean square error of predictions over the horizon, on shots that naming "
            "never saw: with the simulator as it was, amended, and what would remain without any "
            "gap. A line a split; bands: 95 %, bootstrapped over shots.",
        )
        if any(one.verdict.effects for one in own):
            run.add_figure(
                stability_figure(own),
                f"causes_{source}",
                title=f"The causes of the gap to {source}",
                caption="Estimates with their 95 % intervals, a mark a split, as departures from "
                "the simulator in the smallest size that the shots show almost surely. The axis "
                "is linear in the pale band and logarithmic beyond.",
            )


def _metrics(found: Sequence[Diagnosed]) -> dict[str, Any]:
    """Return ``{source: {simulator: {split: {verdict, removable_closed, causes}}}}``."""
    metrics: dict[str, Any] = {}
    for row in verdict_table(found).to_dict("records"):
        told = {"verdict": row["verdict"], "unexplained": rounded(row["unexplained"])}
        if row["removable_closed"] == row["removable_closed"]:  # where there is a gap to close
            told["removable_closed"] = rounded(row["removable_closed"])
        place(metrics, [row[key] for key in CASE]).update(told, causes={})
    for row in cause_table(found).to_dict("records"):
        numbers = {name: rounded(row[name]) for name in ("estimate", "low", "high")}
        place(metrics, [*(row[key] for key in CASE), "causes"])[row["cause"]] = numbers
    return metrics


if __name__ == "__main__":
    run_stage(close_gap)
