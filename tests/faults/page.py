"""The tables of docs/reliability.md, from what `make faults` wrote."""

import pandas as pd

from tests.reliability import REPORT


def kills_table(kills: pd.DataFrame) -> str:
    """One row per stage: number, times and results of the kills."""
    lines = [
        "| stage | kills | time of kill (% of the stage) | after its end | half-written files "
        "| identical hashes | DVC's files repaired |",
        "|---|---|---|---|---|---|---|",
    ]
    for stage, rows in kills.groupby("stage", sort=False):
        hits = rows[rows["hit"]]
        times = ", ".join(f"{100 * share:.0f}" for share in sorted(hits["share"]))
        lines.append(
            f"| {stage} | {len(hits)} | {times} | {len(rows) - len(hits)} "
            f"| {hits['half_written'].sum()} | {hits['same_hashes'].sum()} of {len(hits)} "
            f"| {rows['repaired'].count()} |"
        )
    hits = kills[kills["hit"]]
    lines.append(
        f"| all | {len(hits)} | | {len(kills) - len(hits)} | {hits['half_written'].sum()} "
        f"| {hits['same_hashes'].sum()} of {len(hits)} | {kills['repaired'].count()} |"
    )
    return "\n".join(lines)


def faults_table(faults: pd.DataFrame) -> str:
    """One row per fault: result and message of the run."""
    lines = ["| fault | stage | result | message | identical hashes |", "|---|---|---|---|---|"]
    for row in faults.fillna({"message": ""}).itertuples():
        message = row.message.replace("|", "\\|")
        message = f"`{message}`" if message else "–"
        same = "yes" if row.same_hashes else "no"
        lines.append(f"| {row.fault} | {row.stage} | {row.happened} | {message} | {same} |")
    return "\n".join(lines)


def tables() -> list[str]:
    """Both tables of the committed run."""
    return [
        kills_table(pd.read_csv(REPORT / "kills.csv")),
        faults_table(pd.read_csv(REPORT / "faults.csv")),
    ]


if __name__ == "__main__":
    print("\n\n".join(tables()))  # noqa: T201
