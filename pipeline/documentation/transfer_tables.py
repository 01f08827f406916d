"""Tables of policies: in another simulator, on replayed shots, and trained for longer."""

from pathlib import Path
from typing import Any

from rallygap.pipeline.documentation.cells import (
    NONE,
    in_points,
    predictor_name,
    read_report,
    with_interval,
)
from rallygap.pipeline.io.markdown import markdown_table
from rallygap.pipeline.transfer.transfer_table import PROTOCOLS
from rallygap.pipeline.web.labels import SIMULATORS

HORIZONS = ("115-125", "170-180")
OF_STUDY, SIGNIFICANT = ["observation", "horizons_ms", "predictor"], 0.05
READ = ("physics", "transformer", "amended", "oracle")
METRICS = {"speed": ".1f", "spin": ".0f", "clearance": ".2f", "win_probability": ".2f"}
KINDS = {  # of policies
    "exact": "exact forecasts",
    "filtered": "a filter's forecasts",
    "filtered_with_spread": "a filter's forecasts and standard deviations",
}
TRAININGS = (  # goals and inputs of policies, the table of their tests, their group in it
    ("landing", "intercept", "swap_study/policies.csv", "sim2sim"),
    ("landing", "strict", "swap_study/policies.csv", "strict"),
    ("landing, speed and topspin", "intercept", "shots/train_policy/policies.csv", "sim2sim"),
)


def points(gains: Any) -> str:
    """Return the range of differences in points, and how many are significant after Holm."""
    return f"{_range(gains)} points ({_significant(gains)} differences significant)"


def _range(gains: Any) -> str:
    low, high = 100 * gains["difference"].min(), 100 * gains["difference"].max()
    least, most = f"{low:+z.0f}", f"{high:+z.0f}"
    return least if least == most else f"{least} to {most}"


def _significant(gains: Any) -> str:
    return f"{(gains['p_holm'] < SIGNIFICANT).sum()} of {len(gains)}"


def sim2sim_returns(root: Path, run: str = "") -> str:
    """Return rates with the true and with the policy's own simulator, from ``sim2sim``."""
    rates = read_report(root, f"{run}sim2sim/return_rate.csv")
    rates = rates.set_index(["protocol", "simulator", "horizons_ms", "predictor"])["return_rate"]
    rows = []
    for gain in read_report(root, f"{run}sim2sim/difference.csv").itertuples():
        setting = (gain.protocol, gain.simulator, gain.horizons_ms)
        shares = [f"{100 * rates[(*setting, one)]:.0f}" for one in ("ground_truth", "imperfect")]
        simulator = SIMULATORS[gain.simulator]
        rows.append([gain.protocol, simulator, gain.horizons_ms, *shares, in_points(gain)])
    head = ["protocol", "trained in", "horizons (ms)", "true simulator", "own simulator"]
    return markdown_table([*head, "difference (points)"], rows)


def sim2sim_gains(root: Path) -> str:
    """By how much forecasts of the true simulator change returns, by protocol and run."""
    parts = []
    for run, name in (("", "laptop"), ("paper/", "paper")):
        gains = read_report(root, f"{run}sim2sim/difference.csv").set_index("protocol")
        first, again = (points(gains.loc[one]) for one in ("first_state", "re_anchored"))
        parts.append(
            f"in the run `{name}` by {first} where forecasts start from the first state, and by "
            f"{again} where they start from the true state at every control step"
        )
    return (
        "Forecasts of the true simulator instead of the policy's own change returns "
        f"{'; '.join(parts)}."
    )


def sim2real_counts(root: Path, run: str = "") -> str:
    """Hits and returns of replayed shots of a run and of the paper, from ``sim2real``."""
    rows = []
    for row in read_report(root, f"{run}sim2real/transfer.csv").to_dict("records"):
        shots = [f"{row['set']}, {row['shots']}", row["learned_predictor"]]
        for horizons in HORIZONS:
            counts = (
                f"{round(row[f'{horizons} ms: {predictor} {outcome}'], 1):g}"
                for outcome in ("hits", "returns")
                for predictor in ("physics", "learned")
            )
            rows.append([*shots, horizons, *counts])
    head = ["shots", "learned predictor", "horizons (ms)", "hits, physics", "hits, learned"]
    return markdown_table([*head, "returns, physics", "returns, learned"], rows)


def both_readings(root: Path, run: str) -> str:
    """Returns of replayed shots of a run under both readings of Table I, in %, and the gains."""
    key = ["set", "horizons_ms", "protocol", "predictor"]
    rates = read_report(root, f"{run}sim2real/rates.csv").set_index(key)["return_rate"]
    query = "predictor == 'transformer' and outcome == 'returns' and protocol == 'every_tick'"
    first, every = (
        read_report(root, f"{run}sim2real/{name}.csv", query).set_index(key[:2])
        for name in ("difference_first_window", "difference")
    )
    columns = [("first_window", "physics"), *(("every_tick", one) for one in READ)]
    rows = []
    for shots in first.index:
        shares = [f"{100 * rates[(*shots, *column)]:.0f}" for column in columns]
        rows.append([*shots, *shares, *(in_points(one.loc[shots]) for one in (first, every))])
    names = [f"{predictor_name(one)}, {PROTOCOLS[protocol]}" for protocol, one in columns]
    gains = [
        f"transformer minus physics, {PROTOCOLS[one]}" for one in ("first_window", "every_tick")
    ]
    return markdown_table(["shots", "horizons (ms)", *names, *gains], rows)


def real_swap(root: Path) -> str:
    """Returns of measured shots by physics and the fine-tuned transformer, from the run `real`."""
    rates = read_report(root, "real/sim2real/rates.csv", "protocol == 'every_tick'")
    rates = rates.set_index(["set", "horizons_ms", "predictor"])
    query = "outcome == 'returns' and predictor == 'transformer_fine_tuned'"
    gains = read_report(root, "real/sim2real/difference.csv", query)
    rows = []
    for gain in gains[~gains["set"].str.startswith(("stroke", "receive"))].itertuples():
        both = [rates.loc[(gain.set, gain.horizons_ms, one)] for one in ("physics", gain.predictor)]
        counts = (f"{one['returns']:.0f}" for one in both)
        shots = f"{gain.set}, {both[0]['balls']:.0f}"
        rows.append([shots, gain.horizons_ms, *counts, in_points(gain)])
    names = [predictor_name("physics_c"), predictor_name("transformer_fine_tuned")]
    return markdown_table(["shots", "horizons (ms)", *names, "difference (points)"], rows)


def shot_quality(root: Path) -> str:
    """Medians of what the paper's Figure 5 shows, over the returns at the nearer horizons."""
    nearer = f"horizons_ms == '{HORIZONS[0]}'"
    table = read_report(root, "shots/shot_quality/quality.csv", nearer)
    rows = []
    for one in table.to_dict("records"):
        medians = (
            with_interval(one[metric], one[f"{metric}_low"], one[f"{metric}_high"], form)
            for metric, form in METRICS.items()
        )
        reading = PROTOCOLS[one["protocol"]]
        named = [one["set"], predictor_name(one["predictor"]), reading, f"{one['returns']:.0f}"]
        rows.append([*named, *medians])
    head = ["shots", "predictor", "forecasts", "returns", "speed (m/s)", "spin (rad/s)"]
    return markdown_table([*head, "net clearance (m)", "winning probability"], rows)


def spread_policies(root: Path) -> str:
    """Return rates by what policies learn from and observe, from ``make spread-policies``."""
    rates = read_report(root, "spread_policies.csv")
    query = "outcome == 'returns' and policy == 'filtered_with_spread'"
    gains = read_report(root, "spread_policies_differences.csv", query)
    gains = gains.set_index(["set", "predictor"])
    rows = []
    for (name, predictor), some in rates.groupby(["set", "predictor"], sort=False):
        of_kind = some.set_index("policy")
        shares = [f"{100 * of_kind.loc[kind, 'return_rate']:.0f}" for kind in KINDS]
        gain = in_points(gains.loc[(name, predictor)])
        rows.append([name, predictor_name(predictor), *shares, gain])
    return markdown_table(["shots", "predictor", *KINDS.values(), "difference (points)"], rows)


def longer_trainings(root: Path) -> str:
    """Returns of policies of simulator C trained for longer, from the swap study and `shots`."""
    rows = []
    for goal, inputs, table, group in TRAININGS:
        query = f"group == '{group}' and simulator == 'imperfect_c'"
        policies = read_report(root, table, query)
        for horizons, some in policies.groupby("horizons_ms", sort=False):
            means = some.mean(numeric_only=True)
            slopes = means.reindex(["speed_slope", "topspin_slope"]).map("{:.2f}".format)
            rates = ", ".join(f"{100 * rate:.1f}" for rate in some["return_rate"])
            numbers = [f"{means['control_steps']:,.0f}", rates, f"{means['landing_error_m']:.2f}"]
            rows.append([goal, inputs, horizons, *numbers, *slopes.replace("nan", NONE)])
    head = ["goal", "inputs", "horizons (ms)", "control steps", "returns (%), each training"]
    return markdown_table([*head, "landing error (m)", "slope, speed", "slope, topspin"], rows)


def swap_readings(root: Path, protocol: str) -> str:
    """Returns of predictors under a reading of Table I, and their gains, from the swap study."""
    query = f"protocol == '{protocol}'"
    shares = read_report(root, "swap_study/readings_all.csv", query)
    gains = read_report(root, "swap_study/gains.csv", f"{query} and outcome == 'returns'")
    return _by_policy(shares.set_index(OF_STUDY)["return_rate"], gains.set_index(OF_STUDY))


def swap_every_tick(root: Path) -> str:
    """What forecasts at every control step gain over those from the first window."""
    query = "outcome == 'returns' and protocol == 'every_tick'"
    gains = read_report(root, "swap_study/gains_every_tick.csv", query).set_index(OF_STUDY)
    shares = read_report(root, "swap_study/readings_all.csv", "protocol == 'every_tick'")
    return _by_policy(shares.set_index(OF_STUDY)["return_rate"], gains)


def swap_table_one(root: Path) -> str:
    """The difference between the columns of the paper's Table I, in the swap study."""
    shares = read_report(root, "swap_study/readings_all.csv")
    keys = ["protocol", "predictor", *OF_STUDY[:2]]
    shares = shares.set_index(keys)["return_rate"].sort_index()
    gains = shares["every_tick", "transformer"] - shares["first_window", "physics_c"]
    return f"{_range(gains.to_frame('difference'))} points"


def swap_mechanism(root: Path) -> str:
    """Gains over simulator C by label error and time between forecasts, without latency."""
    query = "outcome == 'returns' and latency_ms == 0"
    gains = read_report(root, "swap_study/gains_mechanism.csv", query)
    gains = gains.assign(first=gains["every_ms"] == "first window")
    rows = []
    for (error, predictor), some in gains.groupby(["label_error", "predictor"]):
        ages = (some[some["first"]], some[~some["first"]])
        cells = (f"{_range(one)} ({_significant(one)})" for one in ages)
        rows.append([f"{100 * error:.0f}", predictor_name(predictor), *cells])
    head = ["label error (%)", "predictor", "from the first window (points)"]
    return markdown_table([*head, "every 40 to 320 ms (points)"], rows)


def swap_latency(root: Path) -> str:
    """The most returns with a latency of 100 ms, by any predictor, in %."""
    rates = read_report(root, "swap_study/mechanism.csv", "latency_ms == 100")
    return f"{100 * rates['return_rate'].max():.0f} %"


def swap_retrained(root: Path) -> str:
    """Returns of original and retrained policies by predictor, from the swap study."""
    shares = read_report(root, "swap_study/retrained.csv")
    shares = shares.set_index(["policy", "horizons_ms", "predictor"])["return_rate"]
    rows = []
    for row in read_report(
        root, "swap_study/gains_retrained.csv", "outcome == 'returns'"
    ).itertuples():
        both = [shares[one, row.horizons_ms, row.predictor] for one in ("original", "retrained")]
        rows.append(
            [
                row.horizons_ms,
                predictor_name(row.predictor),
                *(f"{100 * one:.0f}" for one in both),
                _gain(row),
            ]
        )
    head = ["horizons (ms)", "predictor", "original", "retrained", "difference (points)"]
    return markdown_table(head, rows)


def _by_policy(shares: Any, gains: Any) -> str:
    """Return a row a predictor, a column an observation and horizons."""
    policies = list(dict.fromkeys(key[:2] for key in shares.index))
    rows = []
    for predictor in dict.fromkeys(key[2] for key in shares.index):
        cells = []
        for policy in policies:
            key = (*policy, predictor)
            share = f"{100 * shares[key]:.0f}"
            cells.append(f"{share}, {_gain(gains.loc[key])}" if key in gains.index else share)
        rows.append([predictor_name(predictor), *cells])
    return markdown_table(["predictor", *(f"{one}, {ms} ms" for one, ms in policies)], rows)


def _gain(row: Any) -> str:
    """Return a difference in points with its interval, marked where all comparisons allow it."""
    return in_points(row) + (" *" if row.p_holm < SIGNIFICANT else "")
