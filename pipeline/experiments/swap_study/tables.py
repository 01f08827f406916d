"""The tables of the study."""

from collections.abc import Mapping

import pandas as pd

from rallygap.pipeline.experiments.swap_study.policies import RETRAINED_KIND
from rallygap.pipeline.transfer.rates import differences, rates
from rallygap.pipeline.transfer.replay_trials import EVERY_STEP, ONCE
from rallygap.pipeline.transfer.retraining import ORIGINAL, RETRAINED

EXPERIMENTS = ("readings", "mechanism", "retrained")
PHYSICS = "physics_c"  # what others are compared with
POLICY, MECHANISM = ["observation", "horizons_ms"], ["every_ms", "latency_ms", "label_error"]


def study_tables(played: Mapping[str, pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """Return all tables by name, from the trials of each experiment."""
    readings, mechanism, retrained = (played[name] for name in EXPERIMENTS)
    per_reading = [*POLICY, "predictor", "protocol"]
    both = pd.concat([_as_retrained(readings), retrained.assign(policy=RETRAINED)])
    shares = {
        "readings": (readings, ["set", *per_reading]),
        "readings_all": (readings, per_reading),
        "mechanism": (mechanism, [*POLICY, "predictor", *MECHANISM]),
        "retrained": (both, ["policy", "horizons_ms", "predictor"]),
    }
    physics = {"predictor": PHYSICS}
    first, original = {"protocol": ONCE}, {"policy": ORIGINAL}
    gains = {
        "gains": (readings, [*POLICY, "protocol"], physics),
        "gains_by_set": (readings, ["set", *POLICY, "protocol"], physics),
        "gains_every_tick": (readings, [*POLICY, "predictor"], first),
        "gains_mechanism": (mechanism, [*POLICY, *MECHANISM], physics),
        "gains_retrained": (both, ["horizons_ms", "predictor"], original),
    }
    return {
        **{name: rates(*one) for name, one in shares.items()},
        **{name: differences(*one) for name, one in gains.items()},
    }


def _as_retrained(readings: pd.DataFrame) -> pd.DataFrame:
    """Return the trials of the original policies like those that are trained again."""
    alike = (readings["observation"] == RETRAINED_KIND) & (readings["protocol"] == EVERY_STEP)
    return readings[alike].assign(policy=ORIGINAL)
