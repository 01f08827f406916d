"""Tables of policies: in another simulator, on replayed shots, and trained for longer."""

from pathlib import Path

import pandas as pd

from pipeline.documentation.tables.markdown import (
    NONE,
    PREDICTORS,
    read_report,
    with_interval,
)
from pipeline.io.markdown import markdown_table

HORIZONS = ("115-125", "170-180")
TRAININGS = (  # what policies observe, the kept run that trained them, their group in it
    ("landing", "policies", "sim2sim"),
    ("landing, the paper's inputs only", "policies", "strict"),
    ("landing, speed and topspin", "shots", "sim2sim"),
)


def sim2sim_returns(root: Path, run: str = "") -> str:
    """Return rates with the true and with the policy's own simulator, from ``sim2sim``."""
    rates = read_report(root, f"{run}sim2sim/return_rate.csv")
    own = rates.set_index(["protocol", "simulator", "horizons_ms", "predictor"])["return_rate"]
    rows = []
    for gain in read_report(root, f"{run}sim2sim/difference.csv").itertuples():
        setting = (gain.protocol, gain.simulator, gain.horizons_ms)
        shares = (100 * own[(*setting, one)] for one in ("ground_truth", "imperfect"))
        rows.append(
            [
                gain.protocol,
                gain.simulator[-1].upper(),
                gain.horizons_ms,
                *(f"{share:.0f}" for share in shares),
                _points(gain),
            ]
        )
    head = ["protocol", "trained in", "horizons (ms)", "true simulator", "own simulator"]
    return markdown_table([*head, "difference (points)"], rows)


def sim2real_counts(root: Path, run: str = "") -> str:
    """Hits and returns of replayed shots of a run and of the paper, from ``sim2real``."""
    rows = []
    for row in read_report(root, f"{run}sim2real/transfer.csv").to_dict("records"):
        for horizons in HORIZONS:
            counts = (
                f"{row[f'{horizons} ms: {predictor} {outcome}']:.0f}"
                for outcome in ("hits", "returns")
                for predictor in ("physics", "learned")
            )
            rows.append(
                [f"{row['set']}, {row['shots']}", row["learned_predictor"], horizons, *counts]
            )
    head = ["shots", "learned predictor", "horizons (ms)", "hits, physics", "hits, learned"]
    return markdown_table([*head, "returns, physics", "returns, learned"], rows)


def real_swap(root: Path) -> str:
    """Returns of measured shots by physics and the fine-tuned transformer, from the run `real`."""
    rates = read_report(root, "real/sim2real/rates.csv").query("protocol == 'every_tick'")
    rates = rates.set_index(["set", "horizons_ms", "predictor"])
    gains = read_report(root, "real/sim2real/difference.csv")
    gains = gains.query("outcome == 'returns' and predictor == 'transformer_fine_tuned'")
    rows = []
    for gain in gains[~gains["set"].str.startswith(("stroke", "receive"))].itertuples():
        both = [rates.loc[(gain.set, gain.horizons_ms, one)] for one in ("physics", gain.predictor)]
        counts = (f"{one['returns']:.0f}" for one in both)
        shots = f"{gain.set}, {both[0]['balls']:.0f}"
        rows.append([shots, gain.horizons_ms, *counts, _points(gain)])
    learned = PREDICTORS["transformer_fine_tuned"]
    return markdown_table(
        ["shots", "horizons (ms)", PREDICTORS["physics_c"], learned, "difference (points)"], rows
    )


def longer_trainings(root: Path) -> str:
    """Returns of policies trained for longer, from the kept runs `policies` and `shots`."""
    rows = []
    for observed, run, group in TRAININGS:
        policies = read_report(root, f"{run}/train_policy/policies.csv")
        for horizons, some in policies[policies["group"] == group].groupby(
            "horizons_ms", sort=False
        ):
            means = some.mean(numeric_only=True)
            slopes = (means.get(name) for name in ("speed_slope", "topspin_slope"))
            rows.append(
                [
                    observed,
                    str(horizons),
                    f"{means['ticks']:,.0f}",
                    ", ".join(f"{100 * rate:.1f}" for rate in some["return_rate"]),
                    f"{means['landing_error_m']:.2f}",
                    *(NONE if pd.isna(slope) else f"{slope:.2f}" for slope in slopes),
                ]
            )
    head = ["goal", "horizons (ms)", "environment steps", "returns (%), three seeds"]
    return markdown_table([*head, "landing error (m)", "slope, speed", "slope, topspin"], rows)


def _points(gain: object) -> str:
    """Return a difference of shares in points, with its interval."""
    ends = (100 * getattr(gain, name) for name in ("difference", "ci_low", "ci_high"))
    return with_interval(*ends)
