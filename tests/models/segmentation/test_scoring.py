"""Scores of detected contacts against the truth."""

import numpy as np
import pandas as pd
import pytest

from rallygap.models.segmentation.scoring import in_play, match_contacts, observable, score
from rallygap.models.segmentation.settings import ScoringSettings

SETTINGS = ScoringSettings()


def contacts(*rows, recording_id="arena/1"):
    table = pd.DataFrame(rows, columns=["t", "kind", "py"])
    velocity = {"vx": 0.0, "vy": 3.0, "vz": 4.0}
    return table.assign(recording_id=recording_id, **velocity)


TRUE = contacts(
    (0.0, "launch", 1.5), (0.5, "racket", 1.5), (0.7, "table", 0.7), (1.0, "table", -0.7)
)
SAMPLES = pd.DataFrame({"recording_id": "arena/1", "t": np.arange(0.0, 1.5, 0.005)})


@pytest.mark.parametrize(
    ("kinds", "y", "expected"),
    [
        # A serve, a return, a second bounce, and what the ball does then.
        ("launch racket table table racket table table table", [1, 1, 1, -1, -1, 1, 1, 1], 7),
        ("launch racket net table floor floor", [1, 1, 0, 1, 2, 3], 5),
        ("launch table floor table", [1, -1, -2, -2], 3),
    ],
)
def test_play_ends_on_the_floor_or_with_a_second_bounce(kinds, y, expected):
    playing = in_play(np.array(kinds.split()), np.array(y, dtype=float))
    np.testing.assert_array_equal(playing, np.arange(len(y)) < expected)


@pytest.mark.parametrize(
    ("samples", "expected"),
    [
        ([0.98, 0.985, 0.99, 1.01, 1.015, 1.02], True),
        ([0.98, 0.985, 1.01, 1.015, 1.02], False),
        ([0.97, 0.985, 0.99, 1.01, 1.015, 1.02], False),  # the first is too long before
        ([0.98, 0.985, 0.99, 1.01, 1.02, 1.024], False),  # the last is beyond the next contact
    ],
)
def test_contact_is_observable_with_three_samples_on_each_side(samples, expected):
    contact_times = np.array([1.0, 1.022])
    assert observable(contact_times, np.array(samples), SETTINGS)[0] == expected


def test_closest_pairs_match_first_and_only_once():
    true, found = np.array([1.0, 1.004, 2.0]), np.array([1.003, 1.9, 2.001])
    assert match_contacts(true, found, 0.005).tolist() == [-1, 0, 2]


def test_what_is_found_in_time_is_detected_and_a_wrong_kind_or_a_late_one_is_false():
    scored = score(TRUE, TRUE[TRUE["kind"] != "launch"], SAMPLES, SETTINGS)
    assert scored.true["kind"].tolist() == ["racket", "table", "table"]
    assert scored.true[["observable", "detected"]].all(axis=None)
    assert (scored.true["error"] == 0).all()
    assert scored.true["speed"].tolist() == [5.0, 4.0, 4.0]
    assert scored.false.empty
    found = contacts((0.5, "table", 1.5), (0.706, "table", 0.7), (1.002, "table", -0.7))
    scored = score(TRUE, found, SAMPLES, SETTINGS)
    assert scored.true["detected"].tolist() == [False, False, True]
    assert scored.true["error"].iloc[2] == pytest.approx(0.002)
    assert scored.false["kind"].tolist() == ["table", "table"]


def test_contacts_match_only_within_their_recording_and_without_truth_there_is_none():
    elsewhere = contacts((0.5, "racket", 1.5), recording_id="arena/2")
    assert not score(TRUE, elsewhere, SAMPLES, SETTINGS).true["detected"].any()
    scored = score(TRUE.iloc[:0], TRUE.iloc[:0], SAMPLES.iloc[:0], SETTINGS)
    assert scored.true.empty
    assert scored.false.empty
