"""The tables of the study."""

from collections.abc import Mapping

import pandas as pd

from pipeline.swap_study.comparisons import differences, rates
from pipeline.swap_study.policies import RETRAINED_KIND
from pipeline.transfer.replay_trials import EveryStep, FirstWindow
from pipeline.transfer.retraining import ORIGINAL, RETRAINED

EXPERIMENTS = ("readings", "mechanism", "retrained")
PHYSICS = "physics_c"  # what others are compared with
POLICY, MECHANISM = ["observation", "horizons_ms"], ["age_ms", "latency_ms", "label_error"]


def study_tables(played: Mapping[str, pd.DataFrame], seed: int) -> dict[str, pd.DataFrame]:
    """Return all tables by name, from the trials of each experiment."""
    readings, mechanism, retrained = (played[name] for name in EXPERIMENTS)
    per_reading = [*POLICY, "predictor", "protocol"]
    both = pd.concat([_as_retrained(readings), retrained.assign(policy=RETRAINED)])
    return {
        "readings": rates(readings, ["set", *per_reading], seed),
        "readings_all": rates(readings, per_reading, seed),
        "gains": differences(readings, [*POLICY, "protocol"], "predictor", PHYSICS, seed),
        "gains_by_set": differences(
            readings, ["set", *POLICY, "protocol"], "predictor", PHYSICS, seed
        ),
        "gains_every_tick": differences(
            readings, [*POLICY, "predictor"], "protocol", FirstWindow.protocol, seed
        ),
        "mechanism": rates(mechanism, [*POLICY, "predictor", *MECHANISM], seed),
        "gains_mechanism": differences(
            mechanism, [*POLICY, *MECHANISM], "predictor", PHYSICS, seed
        ),
        "retrained": rates(both, ["policy", "horizons_ms", "predictor"], seed),
        "gains_retrained": differences(
            both, ["horizons_ms", "predictor"], "policy", ORIGINAL, seed
        ),
    }


def _as_retrained(readings: pd.DataFrame) -> pd.DataFrame:
    """Return the trials of the original policies like those that are trained again."""
    alike = (readings["observation"] == RETRAINED_KIND) & (
        readings["protocol"] == EveryStep.protocol
    )
    return readings[alike].assign(policy=ORIGINAL)
