"""The stage on policies that chase the forecast ball: better forecasts give more hits."""

import json

import numpy as np
import pytest

from rallygap.pipeline.io.metrics import place
from rallygap.pipeline.policies.storage import save_policy
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.stages.sim2sim import sim2sim
from tests.pipeline.measured_shots import params
from tests.pipeline.trained_policies import chaser, description
from tests.stages import outputs
from tests.stages.outputs import written

HORIZONS = (115, 120, 125)
POLICIES = [("imperfect_c", 0), ("imperfect_c", 1), ("ground_truth", 0)]


def save_chaser(root, simulator, repeat, horizons=HORIZONS):
    goals = params().train_policy.groups["sim2sim"].goals
    trained = description(
        group="sim2sim", simulator=simulator, horizons=horizons, goals=goals, repeat=repeat
    )
    save_policy(root / "artifacts/train_policy" / trained.name, chaser(6.0 - 3 * repeat), trained)


def judged(root, **changes):
    """The run and its metrics, on few balls."""
    few = {"episodes": 24, **changes}
    settings = params().sim2sim.model_copy(update=few)
    run = StageRun("sim2sim", root, params(sim2sim=settings))
    sim2sim(run)
    return run, rates_and_gains(run)


def rates_and_gains(run):
    """Return rates of every seed, and gains, by protocol, simulator and horizons."""
    found = {}
    keys = ["protocol", "simulator", "horizons_ms"]
    for row in run.kept("sim2sim", "rates").to_dict("records"):
        rate = {"mean": row["return_rate"], "std": row["std"], "per_seed": list(row["per_seed"])}
        own = place(found, [*(row[key] for key in keys), row["predictor"]])
        own.update(return_rate=rate, hit_rate=row["hit_rate"])
    for row in run.kept("sim2sim", "differences").to_dict("records"):
        gain = {"mean": row["difference"], "low": row["ci_low"], "high": row["ci_high"]}
        place(found, [*(row[key] for key in keys), "difference"]).update(gain)
    return found


def test_metrics_are_the_gains(whole):
    run, found = whole
    metrics = json.loads(run.report("metrics.json").read_text())
    for protocol, gain in metrics.items():
        gains = [
            one["difference"]["mean"] for at in found[protocol].values() for one in at.values()
        ]
        assert gain["gain"] == pytest.approx(np.mean(gains), abs=1e-5)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """One run with all policies; not to be changed."""
    root = tmp_path_factory.mktemp("whole")
    for simulator, repeat in POLICIES:
        save_chaser(root, simulator, repeat)
    return judged(root)


def table(run, name, simulator):
    rows = outputs.table(run, name)
    return rows[rows["simulator"] == simulator].set_index("protocol")


def test_identical_simulators_differ_by_exactly_nothing(whole):
    run, metrics = whole
    for protocol in metrics.values():
        place = protocol["ground_truth"]["115-125"]
        assert place["ground_truth"] == place["imperfect"]
        assert place["ground_truth"]["return_rate"]["mean"] > 0
        assert place["difference"] == {"mean": 0.0, "low": 0.0, "high": 0.0}
    rows = table(run, "difference", "ground_truth")
    assert (rows[["gained", "lost"]] == 0).all(axis=None)


def test_forecasts_by_the_true_simulator_are_exact_and_give_more_hits(whole):
    run, metrics = whole
    rows = table(run, "return_rate", "imperfect_c").set_index("predictor", append=True)
    error, hits = rows["forecast_error_m"], rows["hit_rate"]
    for protocol in metrics:
        assert error[protocol, "ground_truth"] < 1e-5
    assert error["first_state", "imperfect"] > 10 * error["re_anchored", "imperfect"] > 0.03
    assert hits["first_state", "ground_truth"] > hits["first_state", "imperfect"] + 0.05
    assert abs(hits["first_state", "ground_truth"] - hits["re_anchored", "ground_truth"]) < 0.05


def test_policies_of_one_setting_are_taken_together(whole):
    _, metrics = whole
    place = metrics["first_state"]["imperfect_c"]["115-125"]
    for predictor in ("ground_truth", "imperfect"):
        rate = place[predictor]["return_rate"]
        assert len(rate["per_seed"]) == 2
        assert rate["mean"] == pytest.approx(np.mean(rate["per_seed"]), rel=1e-5)
        assert rate["std"] == pytest.approx(np.std(rate["per_seed"]), abs=1e-6)
    means = [place[name]["return_rate"]["mean"] for name in ("ground_truth", "imperfect")]
    assert place["difference"]["mean"] == pytest.approx(means[0] - means[1], abs=1e-5)


def test_a_policy_meets_the_same_balls_whoever_else_plays(whole, tmp_path):
    save_chaser(tmp_path, "ground_truth", 0)
    save_chaser(tmp_path, "ground_truth", 0, horizons=(170, 175, 180))
    _, metrics = judged(tmp_path, protocols=["re_anchored"])
    places = metrics["re_anchored"]["ground_truth"]
    assert set(places) == {"115-125", "170-180"}
    assert places["115-125"] == whole[1]["re_anchored"]["ground_truth"]["115-125"]


def test_the_same_inputs_give_the_same_bytes(tmp_path):
    runs = []
    for name in ("once", "again"):
        save_chaser(tmp_path / name, "imperfect_c", 0)
        runs.append(judged(tmp_path / name, episodes=6)[0])
    first, second = map(written, runs)
    assert first and first == second


def test_without_policies_of_the_group_there_is_one_error_and_no_metrics(tmp_path):
    save_chaser(tmp_path, "imperfect_c", 0)
    with pytest.raises(InputError, match="no policy of the group other"):
        judged(tmp_path, group="other")
    assert not (tmp_path / "reports").exists()


def test_an_unknown_ground_truth_is_one_error(tmp_path):
    save_chaser(tmp_path, "imperfect_c", 0)
    with pytest.raises(InputError, match="there is no shipped simulator 'perfect'"):
        judged(tmp_path, ground_truth="perfect")
