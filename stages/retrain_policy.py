"""Back into the loop: policies trained anew in the amended simulator play the same balls."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from models.ball.simulator import Simulator
from pipeline.evaluation.predictors import ARENA, read_learned
from pipeline.io.amended_simulators import amended_by, verdict_path
from pipeline.io.artifacts import read_as, read_table, write_table
from pipeline.io.ground_truth import read_truth
from pipeline.io.metrics import place, rounded
from pipeline.io.simulators import load_simulator
from pipeline.params import Sim2RealSettings
from pipeline.policies.storage import save_policy
from pipeline.policies.training import UNSEEN, Graduate, Pupil, train_policies, try_policies
from pipeline.runtime.errors import InputError
from pipeline.runtime.stage_run import StageRun, run_stage
from pipeline.transfer.figures.retraining import loop_figure
from pipeline.transfer.rates import rates
from pipeline.transfer.replay_sets import read_replay_sets
from pipeline.transfer.replay_trials import (
    EveryTick,
    Policies,
    informed,
    players,
    replays,
    source_of,
)
from pipeline.transfer.retraining import (
    KEYS,
    ORIGINAL,
    RETRAINED,
    amended_name,
    anew,
    loop_table,
    pooled,
)
from pipeline.transfer.trials import play_all
from pipeline.transfer.truth_comparison import NamedCauses, number_table

OWN = ["simulator", "horizons_ms"]  # what tells policies apart that play in their own simulator


def retrain_policy(run: StageRun) -> None:
    """Train the policies of sim2real anew, and let old and new ones play the same balls."""
    settings = read_as(run.input("sim2real", "settings.json"), Sim2RealSettings, "sim2real")
    simulators = {
        source: _amended(run, source, settings.simulator)
        for source in run.params.retrain_policy.sources
    }
    before = players(run.input("train_policy", ""), settings)
    graduates = _trained(run, before, simulators)
    replayed = _replayed(run, settings, simulators, graduates)
    write_table(run.artifact("played.parquet"), pd.concat(replayed.values(), ignore_index=True))
    _report(run, settings, replayed, _own(run, settings, graduates))
    _add_number_table(run, settings.simulator, simulators)


def _amended(run: StageRun, source: str, begun: str) -> Simulator:
    found = amended_by(run.input("close_gap", ""), source, begun)
    if found is None:
        problem = f"close_gap has not amended {begun} by balls of {source}; give it both"
        raise InputError("params.yaml", problem, field="retrain_policy.sources")
    return found


def _trained(
    run: StageRun, before: Policies, simulators: Mapping[str, Simulator]
) -> list[Graduate]:
    """Train every policy anew in every amended simulator."""
    wanted = [
        anew(trained, source, simulator)
        for source, simulator in simulators.items()
        for _, trained in before
    ]
    graduates = train_policies([Pupil(one, run.scratch(one.name)) for one in wanted])
    for one in graduates:
        name = one.description.name
        save_policy(run.artifact(name), one.policy, one.description)
        run.timings[name] = {"training_cpu_s": round(one.seconds, 1)}
    return graduates


def _own(run: StageRun, settings: Sim2RealSettings, graduates: Sequence[Graduate]) -> pd.DataFrame:
    """Return how balls of their own simulators ended, as many for every policy."""
    known = read_table(run.input("train_policy", UNSEEN))
    known = known[(known["group"] == settings.group) & (known["simulator"] == settings.simulator)]
    balls = int(known["ball"].max()) + 1
    return pd.concat([known, *try_policies(graduates, balls)], ignore_index=True)


def _replayed(
    run: StageRun,
    settings: Sim2RealSettings,
    simulators: Mapping[str, Simulator],
    graduates: Sequence[Graduate],
) -> dict[str, pd.DataFrame]:
    """Return how the balls of every source ended, with policies of before and after."""
    known = read_table(run.input("sim2real", "played.parquet"))
    known = known[known["protocol"] == EveryTick.protocol].assign(policy=ORIGINAL)
    sets = read_replay_sets(run.root / "artifacts", settings, run.seed)
    learned = read_learned(run.input("train_predictor", ""), settings.learned)
    replayed = {}
    for source, simulator in simulators.items():
        own = [one for one in sets if source_of(one) == source]
        if not own:
            problem = f"no ball of {source} can be replayed; see reports/sim2real/replayed.csv"
            raise InputError("params.yaml", problem, field="retrain_policy.sources")
        after = [
            (one.policy, one.description)
            for one in graduates
            if one.description.simulator == amended_name(source)
        ]
        trials = [
            trial
            for one in own
            for trial in replays(one, informed(one, learned, simulator), after, run.seed)
        ]
        played = known[known["set"].isin([one.name for one in own])]
        parts = [played, play_all(trials).assign(policy=RETRAINED)]
        replayed[source] = pd.concat(parts, ignore_index=True)
    return replayed


def _report(
    run: StageRun,
    settings: Sim2RealSettings,
    replayed: Mapping[str, pd.DataFrame],
    played: pd.DataFrame,
) -> None:
    resamples = settings.bootstrap_resamples
    own = rates(played, OWN, resamples, run.seed)
    before = own[own["simulator"] == settings.simulator].set_index("horizons_ms")["return_rate"]
    tables = [
        loop_table(pooled(one, source), before.to_dict(), resamples, run.seed)
        for source, one in replayed.items()
    ]
    table = pd.concat(tables, ignore_index=True)
    run.write_metrics({"replayed": _nested(table, KEYS), "own_simulator": _nested(own, OWN)})
    caption = _experiment(settings)
    run.add_figure(
        loop_figure(table[table["set"].isin(replayed)]),
        "returns",
        title="Back into the loop: returns of the same balls",
        caption=caption,
    )
    run.add_table(
        table,
        "returns",
        title="Back into the loop: which change closes how much of the gap in returns",
        caption=f"{caption} Original policy with physics: as it was; with a learned predictor: the "
        "swap; with amended: the amended simulator predicts; retrained policy with amended; and "
        "both, the retrained policy with a learned predictor. Rates with their 95 % intervals "
        "(low, high), bootstrapped over balls. difference: of returns to the original, on the same "
        "balls (ci_low, ci_high); gained, lost: balls returned more often, or less. gap_closed: "
        "that difference as a share of the gap, which lies between the original and what the "
        "oracle makes of it, or else its own rate in its own simulator. The share is empty where "
        "no gap is sure.",
    )
    run.add_table(
        own,
        "own_simulator",
        title="Policies in their own simulators",
        caption="Each policy plays balls of the simulator it was trained in that it has never "
        "seen, told their exact future: the original ones as train_policy tried them, the "
        "retrained ones on as many balls. 95 % intervals are bootstrapped over balls.",
    )


def _experiment(settings: Sim2RealSettings) -> str:
    return (
        f"The policies of {settings.group} from {settings.simulator}, and the same trained anew in "
        "the simulator as training balls of the source amended it: same goals, horizons, seeds and "
        "lengths of training. All play the balls of sim2real, told of them at every tick."
    )


def _add_number_table(run: StageRun, begun: str, simulators: Mapping[str, Simulator]) -> None:
    """Set the amended simulators beside the truth, which scores alone may open."""
    truth = read_truth(run.input("ingest", "truth.json"))
    tables = {}
    for source, amended in simulators.items():
        path = verdict_path(run.input("close_gap", ""), source, begun)
        causes = read_as(path, NamedCauses, "close_gap").causes
        known = truth.simulator if truth is not None and source == ARENA else None
        tables[source] = number_table(load_simulator(begun), amended, causes, known)
    run.add_table(
        pd.concat(tables, names=["source"]).reset_index("source"),
        "numbers",
        title="The simulator before and after",
        caption=f"Numbers of {begun} that balls of the source amended, or in which the "
        "truth differs; empty where a simulator lacks the effect. low, high: 95 % interval of what "
        "was named. The truth is known of the arena alone, and was hidden from close_gap.",
    )


def _nested(table: pd.DataFrame, keys: Sequence[str]) -> dict[str, Any]:
    """Return ``{key: {...: {number: value}}}``; what cannot be told is left out."""
    metrics: dict[str, Any] = {}
    for row in table.to_dict("records"):
        numbers = {name: value for name, value in row.items() if name not in keys}
        told = {str(name): rounded(value) for name, value in numbers.items() if np.isfinite(value)}
        place(metrics, [row[key] for key in keys]).update(told)
    return metrics


if __name__ == "__main__":
    run_stage(retrain_policy)
