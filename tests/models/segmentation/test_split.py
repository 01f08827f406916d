"""Assignment of recordings to splits."""

from itertools import chain

import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rallygap.models.segmentation.settings import ReplaySettings, SplitSettings
from rallygap.models.segmentation.split import recording_groups, split

GROUPS = ["cannon", "amateur", "club", "semi_pro", "pro"]
NO_REPLAY = ReplaySettings(stroke_pro=0, stroke_uni=0, receive=0)


def game(recording_id, strokes, far_first=True):
    """A toss, a serve and strokes from both ends in turn; every ball lands on the other half."""
    episodes, contacts = [], []
    for number in range(strokes + 1):
        name = {"recording_id": recording_id, "episode_id": f"{recording_id}/{number:02d}"}
        start = "racket" if number else "recording"
        shown = {"starts_with": start, "bounces": int(number > 0), "unbroken": True}
        episodes.append(name | {"source": recording_id.split("/")[0]} | shown)
        if number:
            end = 1.5 if (number % 2 == 1) == far_first else -1.5
            contacts.append(name | {"kind": "racket", "py": end})
            contacts.append(name | {"kind": "table", "py": -0.5 * end})
    return episodes, contacts


def shot(recording_id):
    name = {"recording_id": recording_id, "episode_id": f"{recording_id}/00"}
    shown = {"starts_with": "launch", "bounces": 1, "unbroken": True}
    bounce = name | {"kind": "table", "py": -0.7}
    return [name | {"source": recording_id.split("/")[0]} | shown], [bounce]


def tables(parts):
    episodes, contacts = (list(chain(*rows)) for rows in zip(*parts, strict=True))
    columns = ["recording_id", "episode_id", "kind", "py"]
    return pd.DataFrame(episodes), pd.DataFrame(contacts, columns=columns)


def simulated_games(games=12, strokes=8, shots=100):
    """Games of all levels and shots of a cannon."""
    parts = [game(f"arena/{level}/{k}", strokes) for level in GROUPS[1:] for k in range(games)]
    return tables(parts + [shot(f"arena/cannon/{k}") for k in range(shots)])


def assigned(episodes, contacts, seed=0, **changes):
    found = split(episodes, contacts, SplitSettings(**changes), seed)
    return episodes.assign(split=found.split, replay_set=found.replay_set), found.shortages


@settings(max_examples=15)
@given(
    counts=st.lists(st.tuples(st.sampled_from(GROUPS), st.integers(1, 9)), min_size=1, max_size=30),
    test=st.integers(0, 40),
    replay=st.integers(0, 20),
    seed=st.integers(0, 2**32 - 1),
)
def test_no_recording_is_in_two_splits(counts, test, replay, seed):
    parts = [game(f"arena/{group}/{k}", strokes) for k, (group, strokes) in enumerate(counts)]
    sets = ReplaySettings(stroke_pro=replay, stroke_uni=replay, receive=replay)
    episodes, _ = assigned(*tables(parts), seed, test_episodes=test, replay=sets)
    assert (episodes.groupby("recording_id")["split"].nunique() == 1).all()
    assert episodes["split"].isin(["train", "validation", "test", "replay"]).all()
    assert (episodes.loc[episodes["replay_set"] != "none", "split"] == "replay").all()


def test_a_split_depends_on_its_seed_and_not_on_other_sources():
    alone, more = simulated_games(), tables([shot(f"gun/{k}") for k in range(50)])
    together = [pd.concat(pair, ignore_index=True) for pair in zip(alone, more, strict=True)]
    one, again, other = (assigned(*alone, seed=seed)[0] for seed in (3, 3, 4))
    pd.testing.assert_frame_equal(one, again)
    assert not one["split"].equals(other["split"])
    both, _ = assigned(*together, seed=3)
    pd.testing.assert_frame_equal(one, both[both["source"] == "arena"])


def test_tests_have_as_many_shots_as_asked_for_in_proportion():
    episodes, shortages = assigned(*simulated_games(), test_episodes=60, replay=NO_REPLAY)
    testing = episodes[(episodes["split"] == "test") & (episodes["bounces"] > 0)]
    of_cannon = recording_groups(testing["recording_id"]) == "cannon"
    # 100 shots of the cannon and 4 x 12 x 8 strokes: a fifth of 60, and whole games for the rest.
    assert of_cannon.sum() == 13
    assert 48 <= (~of_cannon).sum() < 48 + 4 * 8
    assert shortages == []


def test_small_source_gives_a_quarter_to_tests_and_says_so():
    episodes, shortages = assigned(*tables([shot(f"lab/{k}") for k in range(70)]))
    assert (episodes["split"] == "test").sum() == 17
    assert (episodes["split"] == "validation").sum() == 5
    assert set(episodes["replay_set"]) == {"none"}
    assert shortages == ["lab has 17 of 500 shots to test on"]


def test_replayed_shots_are_serves_and_strokes_from_the_far_end():
    sets = ReplaySettings(stroke_pro=5, stroke_uni=9, receive=3)
    episodes, shortages = assigned(*simulated_games(), test_episodes=0, replay=sets)
    chosen = episodes[episodes["replay_set"] != "none"]
    assert chosen["replay_set"].value_counts().to_dict() == sets.model_dump()
    numbers = chosen["episode_id"].str[-2:].astype(int)
    receives = chosen["replay_set"] == "receive"
    assert set(numbers[receives]) == {1}
    assert set(numbers[~receives]) <= {3, 5, 7}
    assert shortages == []


@pytest.mark.parametrize(("column", "value"), [("unbroken", False), ("bounces", 0)])
def test_broken_strokes_and_those_off_the_table_are_not_replayed(column, value):
    episodes, contacts = simulated_games()
    episodes.loc[episodes["episode_id"].str[-2:].astype(int) > 1, column] = value
    found, shortages = assigned(episodes, contacts)
    assert set(found["replay_set"]) == {"none", "receive"}
    assert "stroke_pro has 0 of 200 episodes to replay" in shortages


def test_near_player_s_serves_are_not_replayed():
    episodes, _ = assigned(*tables(game(f"arena/pro/{k}", 1, far_first=False) for k in range(20)))
    assert set(episodes["replay_set"]) == {"none"}
