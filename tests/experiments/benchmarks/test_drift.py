"""The report on drift counts shots, alarms and right names."""

from experiments.benchmarks.drift import CAUSES, QUIET_SHOTS, SHOTS, SIZES, Session, summary
from rallygap.models.gap.hypotheses import Hypothesis

FIRST = next(iter(CAUSES))


def asked():
    """Two sessions without a change, and two of every cause and size."""
    yield from (Session(number, QUIET_SHOTS) for number in range(2))
    for identity in CAUSES:
        for size in SIZES:
            for number in range(2):
                yield Session(number, SHOTS, Hypothesis.from_identity(identity), size)


def test_a_session_counts_up_to_its_alarm_and_a_name_only_if_it_is_right():
    sessions = list(asked())
    alarms = [(30, "wind.x"), None] + [None] * (len(sessions) - 2)
    alarms[2:4] = [(12, FIRST), (20, "gravity.g")]
    found = summary(sessions, alarms)
    assert found["false_alarms"] == 1
    assert found["shots"] == 30 + QUIET_SHOTS
    first = found["causes"][FIRST][f"{SIZES[0]}x"]
    assert first == {"sessions": 2, "alarms": 2, "median_shots": None, "named_right": 0.5}
