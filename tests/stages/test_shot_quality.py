"""The stage shot_quality on simulated games and constructed returns."""

import shutil

import pytest

from rallygap.models.shot_quality.receivers import RECEIVERS
from rallygap.models.shot_quality.settings import ForestSettings
from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.params import ShotQualitySettings
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.stages.shot_quality import shot_quality
from tests.pipeline.measured_shots import params
from tests.pipeline.professional_games import played_games, write_games
from tests.pipeline.returned import trials, write_trials
from tests.stages.outputs import table

SETTINGS = ShotQualitySettings(
    forest=ForestSettings(trees=5, min_samples_leaf=5), folds=2, points=20, bootstrap_resamples=20
)


def stage(root, settings=SETTINGS):
    return StageRun("shot_quality", root, params(shot_quality=settings))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """One run; not to be changed."""
    root = tmp_path_factory.mktemp("whole")
    write_games(root, played_games(6))
    write_trials(root, trials())
    run = stage(root)
    shot_quality(run)
    return run


def test_every_set_horizons_and_predictor_has_its_medians(whole):
    speeds = table(whole, "quality", "set", "horizons_ms", "predictor")["speed"].unstack()
    assert len(speeds) == 4 and (speeds["transformer"] > speeds["physics"]).all()
    rows = table(whole, "scores", "outcome", "method")
    assert len(rows) == 2 * 3
    share = rows.loc[("wins", "forest"), "share"]
    assert 0 < share < rows.loc[("point", "forest"), "share"] < 1
    metrics = read_json(whole.report("metrics.json"))
    assert metrics["forest_roc_auc"]["wins"] == rows.loc[("wins", "forest"), "roc_auc"]


def test_every_receiver_has_its_medians(whole):
    rows = table(whole, "win_probability")
    names = [one.name for one in RECEIVERS]
    assert list(rows.columns[4:]) == ["as_measured", "point", *names]
    own = table(whole, "quality")["win_probability"]
    assert rows["as_measured"].to_numpy() == pytest.approx(own.to_numpy())
    # Who wins with a shot has won the point, too.
    assert rows["point"].mean() > rows["as_measured"].mean()
    agreement = table(whole, "receivers", "receiver")["order_agreement"]
    assert agreement["nominal"] == 1 and agreement.between(0, 1).all()


@pytest.fixture
def again(whole, tmp_path):
    shutil.copytree(whole.root / "artifacts", tmp_path / "artifacts")
    return tmp_path


def test_more_folds_than_matches_are_one_error(again):
    with pytest.raises(InputError, match=r"shot_quality\.folds.*6 matches cannot"):
        shot_quality(stage(again, SETTINGS.model_copy(update={"folds": 7})))


def test_without_a_return_the_forest_is_validated_and_medians_are_missing(again, capsys):
    write_trials(again, trials().assign(returned=False))
    run = stage(again)
    shot_quality(run)
    assert "no ball of sim2real was returned" in capsys.readouterr().err
    rows = table(run, "quality")
    assert (rows["returns"] == 0).all()
    assert rows["speed"].isna().all()
    assert len(table(run, "scores")) == 6
    assert table(run, "out_of_range").empty and table(run, "win_probability").empty
