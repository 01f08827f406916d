"""The tables that recordings become."""

import numpy as np
import pandas as pd
import pytest

from rallygap.models.segmentation.settings import SegmentSettings
from rallygap.models.segmentation.tables import POSITION, SPIN, VELOCITY, segment_recordings
from rallygap.pipeline.io.schemas import CONTACTS, SAMPLES, checked
from tests.models.segmentation.rallies import simulated_rally

SETTINGS = SegmentSettings()


def is_shot(recording_id):
    return recording_id.startswith("gun/")


def recording(name, t, x):
    table = pd.DataFrame({"recording_id": pd.Series([name] * len(t), dtype="str"), "t": t})
    table[POSITION] = x
    table[SPIN] = np.nan
    return table


@pytest.fixture(scope="module")
def recordings():
    rallies = {f"arena/{seed}": simulated_rally(np.random.default_rng(seed)) for seed in range(3)}
    t = 0.005 * np.arange(40)
    shot = np.stack([0 * t, 1 - 5 * t, 0.4 - 4.905 * t**2], axis=1)
    tables = [recording(name, rally.t, rally.x) for name, rally in rallies.items()]
    lone = recording("arena/lone", t[:2], shot[:2])
    return pd.concat([*tables, lone, recording("gun/1", t, shot)], ignore_index=True)


@pytest.fixture(scope="module")
def found(recordings):
    return segment_recordings(recordings, is_shot, SETTINGS)


def test_samples_are_the_measured_ones_and_episodes_agree_with_them_and_their_contacts(
    found, recordings
):
    columns = ["recording_id", "t", *POSITION]
    played = recordings[recordings["recording_id"] != "arena/lone"]
    pd.testing.assert_frame_equal(found.samples[columns], played[columns].reset_index(drop=True))
    for row in found.episodes.to_dict("records"):
        samples = found.samples[found.samples["episode_id"] == row["episode_id"]]
        contacts = found.contacts[found.contacts["episode_id"] == row["episode_id"]]
        assert samples["t"].between(row["start"], row["end"]).all()
        assert contacts["t"].between(row["start"], row["end"]).all()
        assert (row["samples"], row["outliers"]) == (len(samples), samples["outlier"].sum())
        assert row["bounces"] == (contacts["kind"] == "table").sum()
        inside = contacts[contacts["kind"] != "racket"]["t"].to_numpy()
        np.testing.assert_array_equal(samples["arc"], np.searchsorted(inside, samples["t"]))
    lone = recordings[recordings["recording_id"] == "arena/lone"]
    nothing = segment_recordings(lone, is_shot, SETTINGS)
    assert checked(nothing.samples, SAMPLES).empty and checked(nothing.contacts, CONTACTS).empty
    assert nothing.episodes.empty
    first = found.episodes[found.episodes["recording_id"] == "arena/0"]["episode_id"]
    assert first.tolist() == [f"arena/0/{number:02d}" for number in range(len(first))]


def test_launched_ball_begins_with_its_launch(found):
    shot = found.episodes[found.episodes["source"] == "gun"]
    assert shot["starts_with"].tolist() == ["launch"]
    assert shot["residual"].item() < 1e-3
    assert shot["unbroken"].item()
    samples = found.samples[found.samples["recording_id"] == "gun/1"]
    np.testing.assert_allclose(samples[VELOCITY].iloc[0], [0, -5, 0], atol=0.15)
