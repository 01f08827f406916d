"""What of the recordings is used, and why the rest is not."""

from dataclasses import replace

import pandas as pd

from rallygap.pipeline.gap.measured_shots import LabelCounts, read_shots
from rallygap.pipeline.gap.summary import usage_lines
from rallygap.pipeline.gap.wording import episodes_text, labels_text
from tests.pipeline.recorded import write_recordings
from tests.pipeline.verdicts import findings


def test_episodes_and_labels_that_are_left_out_have_a_reason(tmp_path):
    folder = write_recordings(tmp_path / "lab", shots=12)
    short, spun = folder / "000.csv", folder / "001.csv"
    pd.read_csv(short).head(10).to_csv(short, index=False)
    rows = pd.read_csv(spun)
    rows.loc[:4, ["wx", "wy", "wz"]] = 4000.0
    rows.to_csv(spun, index=False)
    found = read_shots(folder, "csv")
    assert episodes_text(found) == "11 of 12 episodes in 12 recordings; left out: 1 too short"
    assert (found.labels.implausible, found.labels.elsewhere) == (5, 10)
    assert found.labels.used == found.shots.labelled.sum()
    read = sum(len(pd.read_csv(path).dropna()) for path in folder.glob("*.csv"))
    assert found.labels.read == read


def test_numbers_are_written_with_their_reasons():
    counts = LabelCounts(read=1240, implausible=37, used=1203)
    assert labels_text(counts) == "1,203 of 1,240; left out: 37 implausible"
    outside = LabelCounts(read=10, implausible=0, used=8)
    assert labels_text(outside) == "8 of 10; left out: 2 outside these episodes"
    assert labels_text(LabelCounts(read=0, implausible=0, used=0)) == "none"


def test_doubts_are_said():
    measured = replace(findings().measured, doubts=("rounded",))
    assert list(usage_lines(measured))[1:] == ["Doubtful: rounded."]
