"""The stage train_predictor: complete, reproducible predictors, or one error and no output."""

import pandas as pd
import pytest
import torch

from rallygap.pipeline.io.artifacts import read_json
from rallygap.pipeline.params import FineTuningSettings
from rallygap.pipeline.predictors.storage import load_network, load_predictor, read_description
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.stage_run import StageRun
from rallygap.stages.train_predictor import train_predictor
from tests.models.predictors.balls import observed
from tests.models.predictors.small_training import BRIEF, TINY, TINY_GRU_TAE, TINY_TAE, changed
from tests.pipeline.measured_shots import params, shot_tables, write_inputs
from tests.stages.outputs import table

NETWORKS = {
    "small": TINY,
    "wide": changed(TINY, width=24, states_per_row=1, uniform_motion=False),
    "tae": TINY_TAE,
    "gru_tae": TINY_GRU_TAE,
}
SPLITS = [*["train"] * 4, *["validation"] * 2]


def shots(*places, splits=SPLITS):
    return [
        shot_tables(place, number, split=split)
        for place in places
        for number, split in enumerate(splits)
    ]


def prepared(root, fine_tuning=(), networks=("small",), splits=SPLITS):
    """A run of the stage on constructed shots."""
    write_inputs(root, shots=shots("arena/club", "labelled/more", splits=splits))
    tuning = FineTuningSettings(sources=list(fine_tuning), epochs=1, windows_per_episode=2)
    changes = {
        "sources": ["arena"],
        "networks": {name: NETWORKS[name] for name in networks},
        "training": BRIEF,
        "fine_tuning": tuning,
    }
    settings = params().train_predictor.model_copy(update=changes)
    return StageRun("train_predictor", root, params(train_predictor=settings), "f" * 64)


def trained(root, **changes):
    run = prepared(root, **changes)
    train_predictor(run)
    return run


@pytest.fixture(autouse=True, scope="module")
def alone():
    """One network after the other, in this process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LOKY_MAX_CPU_COUNT", "1")
        yield


@pytest.fixture(scope="module")
def whole(tmp_path_factory, alone):
    """A run that trains networks of every kind and tunes all; not to be changed."""
    root = tmp_path_factory.mktemp("whole")
    return trained(root, fine_tuning=["labelled"], networks=NETWORKS)


def test_every_network_is_saved_as_a_predictor(whole):
    history, _ = observed()
    for name, settings in NETWORKS.items():
        described = read_description(whole.artifact(name))
        assert (described.name, described.network) == (name, settings)
        assert (described.sources, described.starts_from) == (["arena"], None)
        assert (described.learning.episodes, described.learning.windows) == (4, 4 * 4 * 3)
        assert described.learning.validation_episodes == 2
        assert load_predictor(whole.artifact(name)).predict(history).states.shape == (3, 60, 9)


def test_fine_tuning_starts_from_the_trained_weights(whole):
    described = read_description(whole.artifact("small_fine_tuned"))
    assert (described.sources, described.starts_from) == (["labelled"], "small")
    assert described.learning.settings == changed(BRIEF, epochs=1, windows_per_episode=2)
    before, after = (
        load_network(whole.artifact(name)).state_dict() for name in ("small", "small_fine_tuned")
    )
    moved = {name: (after[name] - before[name]).abs().max().item() for name in before}
    steps = 4 * 2 // BRIEF.batch
    # Adam's first step is the rate.
    assert 0 < max(moved.values()) <= 1.01 * steps * BRIEF.learning_rate
    assert not any(moved[name] for name in moved if name.startswith("normaliser."))


def test_the_report_has_the_losses_of_every_epoch_and_metrics_of_the_last(whole):
    names = [*NETWORKS, *(f"{name}_fine_tuned" for name in NETWORKS)]
    losses = table(whole, "losses", "predictor")
    assert losses.loc["small", "epoch"].tolist() == [1, 2, 3]
    last = table(whole, "training", "predictor")
    assert last["epoch"].to_dict() == dict(zip(names, [3] * 4 + [1] * 4, strict=True))
    pd.testing.assert_frame_equal(last, losses.groupby("predictor", sort=False).last()[[*last]])
    metrics = read_json(whole.report("metrics.json"))
    assert metrics == last["validation"].to_dict()
    scores = {model.folder.name: model.score for model in whole.models}
    assert scores == pytest.approx(metrics)
    assert len({model.name for model in whole.models}) == len(scores)


def test_parallel_training_of_some_gives_the_same_bytes(whole, tmp_path, monkeypatch, capfd):
    monkeypatch.setenv("LOKY_MAX_CPU_COUNT", "2")
    some = ("gru_tae", "small")
    run = trained(tmp_path, fine_tuning=["labelled"], networks=some)
    for name in [*some, *(f"{name}_fine_tuned" for name in some)]:
        for path in whole.artifact(name).iterdir():
            assert path.read_bytes() == run.artifact(f"{name}/{path.name}").read_bytes()
    assert capfd.readouterr() == ("", "")


def test_test_episodes_and_other_sources_do_not_affect_training(whole, tmp_path):
    write_inputs(tmp_path, shots=shots("arena/club"), sources=("arena",))
    run = StageRun("train_predictor", tmp_path, prepared(tmp_path / "settings").params)
    train_predictor(run)
    assert not list(run.artifact(".").glob("*_fine_tuned"))  # no sources for it
    alone, whole_run = (load_network(one.artifact("small")).state_dict() for one in (run, whole))
    assert all(torch.equal(alone[name], whole_run[name]) for name in alone)


@pytest.mark.parametrize("split", ["train", "validation"])
def test_a_split_without_windows_is_an_error_that_names_it(tmp_path, split):
    left = [one for one in SPLITS if one != split]
    run = prepared(tmp_path, networks=("wide",), splits=left)
    with pytest.raises(InputError, match=f"no episode has a window.*: split {split} of arena"):
        train_predictor(run)
    assert not run.artifact("wide").exists()
