"""All tables of the study, from hand-made trials; the documentation reads them."""

from itertools import product

import numpy as np
import pandas as pd
import pytest

from rallygap.pipeline.experiments.swap_study.tables import study_tables

PREDICTORS = ("physics_c", "amended", "transformer")
SHOTS, TRAININGS = 12, 3


def trials(share, **columns):
    """Trials of three trainings on the shots of two sets, of which a share is returned."""
    random = np.random.default_rng(len(str(columns)))
    keys = product(range(TRAININGS), ("stroke_pro", "receive"), range(SHOTS))
    table = pd.DataFrame(keys, columns=["repeat", "set", "ball"])
    returned = random.random(len(table)) < share
    recording = table["set"] + (table["ball"] // 2).astype(str)
    return table.assign(hit=True, returned=returned, recording=recording, **columns)


@pytest.fixture(scope="module")
def tables():
    policies = list(product(("intercept", "strict"), ("115-125", "170-180")))
    readings = [
        trials(0.9 if protocol == "every_tick" else 0.2, predictor=predictor, protocol=protocol,
               observation=observation, horizons_ms=horizons)
        for predictor, protocol, (observation, horizons) in product(
            PREDICTORS, ("first_window", "every_tick"), policies
        )
    ]  # fmt: skip
    mechanism = [
        trials(0.5, predictor=predictor, observation=observation, horizons_ms=horizons,
               protocol="every_steps", every_ms=age, latency_ms=0, label_error=0.0)
        for predictor, age, (observation, horizons) in product(
            PREDICTORS, ("40", "first window"), policies
        )
    ]  # fmt: skip
    retrained = [
        trials(0.95, predictor=predictor, protocol="every_tick", observation="intercept",
               horizons_ms=horizons)
        for predictor, horizons in product(PREDICTORS, ("115-125", "170-180"))
    ]  # fmt: skip
    played = {"readings": readings, "mechanism": mechanism, "retrained": retrained}
    return study_tables({name: pd.concat(some) for name, some in played.items()})


def test_tables_have_a_row_for_every_comparison(tables):
    policies, others = 4, len(PREDICTORS) - 1
    assert len(tables["readings_all"]) == policies * len(PREDICTORS) * 2
    assert len(tables["readings"]) == 2 * len(tables["readings_all"])
    assert len(tables["gains"]) == policies * others * 2 * 2
    assert len(tables["gains_every_tick"]) == policies * len(PREDICTORS) * 2
    assert len(tables["gains_mechanism"]) == policies * others * 2 * 2
    assert len(tables["gains_retrained"]) == 2 * len(PREDICTORS) * 2
    gained = tables["gains_every_tick"].query("outcome == 'returns'")
    assert (gained["difference"] > 0.4).all()
    assert (gained["p_holm"] < 0.01).all()
