"""The report of retrain_policy: metrics, figure, tables and their captions."""

from collections.abc import Mapping

import pandas as pd

from rallygap.models.ball.simulator import Simulator
from rallygap.pipeline.evaluation.predictors import ARENA
from rallygap.pipeline.io.amended_simulators import verdict_path
from rallygap.pipeline.io.artifacts import read_as
from rallygap.pipeline.io.ground_truth import read_truth
from rallygap.pipeline.io.metrics import nested
from rallygap.pipeline.io.report_items import ReportFigure, ReportTable
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import Sim2RealSettings
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.pipeline.transfer.figures.retraining import retraining_figure
from rallygap.pipeline.transfer.rates import rates
from rallygap.pipeline.transfer.retraining import KEYS, pooled, retraining_table
from rallygap.pipeline.transfer.truth_comparison import NamedCauses, number_table

OWN = ["simulator", "horizons_ms"]  # of policies in their own simulators


def report_retraining(
    run: StageRun,
    settings: Sim2RealSettings,
    replayed: Mapping[str, pd.DataFrame],
    in_own_simulator: pd.DataFrame,
) -> None:
    """Write metrics, the figure of return rates, and the tables of rates.

    Args:
        run: of the stage.
        settings: of the sim2real run whose policies were retrained.
        replayed: trials of the original and retrained policies, by source.
        in_own_simulator: trials of all policies in their own simulators.
    """
    own = rates(in_own_simulator, OWN)
    before = own[own["simulator"] == settings.simulator].set_index("horizons_ms")["return_rate"]
    tables = [
        retraining_table(pooled(one, source), before.to_dict()) for source, one in replayed.items()
    ]
    table = pd.concat(tables, ignore_index=True)
    run.write_metrics({"replayed": nested(table, KEYS), "own_simulator": nested(own, OWN)})
    caption = (
        f"The policies of {settings.group} from {settings.simulator}, and the same policies "
        "retrained in the simulator amended from training shots of the source, with the same "
        "goals, horizons, seeds and training iterations. All play the shots of sim2real, with "
        "forecasts at every control step."
    )
    run.add(
        ReportFigure(
            retraining_figure(table[table["set"].isin(replayed)]),
            "returns",
            title="Retraining: return rates on the same shots",
            caption=caption,
        ),
        ReportTable(
            table,
            "returns",
            title="Retraining: share of the gap in returns that each change closes",
            caption=f"{caption} original, physics: the baseline; original with a learned "
            "predictor: the swap; original, amended: the amended simulator predicts; retrained, "
            "amended; and both, retrained with a learned predictor. Rates with 95 % intervals "
            "(low, high) over trainings and recordings. difference: of the return "
            "rate to the baseline's, paired by shot (ci_low, ci_high); gained, lost: shots "
            "returned more often, or less. gap_closed: that difference as a share of the gap "
            "between the baseline and the original policy with the oracle, or without an oracle "
            "its return rate in its own simulator; empty without a significant gap.",
        ),
        ReportTable(
            own,
            "own_simulator",
            title="Policies in their own simulators",
            caption="Each policy plays test shots of the simulator that it was trained in, with "
            "exact forecasts; original and retrained policies play as many. 95 % intervals are "
            "over trainings and shots.",
        ),
    )


def report_parameters(run: StageRun, nominal: str, simulators: Mapping[str, Simulator]) -> None:
    """Add the table of the nominal, amended and true simulator parameters.

    Args:
        run: of the stage.
        nominal: name of the simulator before.
        simulators: amended, by source.
    """
    truth = read_truth(run.input("ingest", "truth.json"))
    tables = {}
    for source, amended in simulators.items():
        path = verdict_path(run.input("close_gap", ""), source, nominal)
        causes = read_as(path, NamedCauses, "close_gap").causes
        known = truth.simulator if truth is not None and source == ARENA else None
        tables[source] = number_table(load_simulator(nominal), amended, causes, known)
    run.add(
        ReportTable(
            pd.concat(tables, names=["source"]).reset_index("source"),
            "numbers",
            title="Simulator parameters before and after",
            caption=f"Parameters of {nominal} that were amended from shots of the source, or that "
            "differ from the truth; empty where a simulator lacks the effect. low, high: 95 % "
            "interval of amended parameters. The truth is known for the arena only, and hidden "
            "from close_gap.",
        )
    )
