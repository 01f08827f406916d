"""Recordings with a hidden cause, as somebody would leave them in a folder of CSV files."""

import pandas as pd

from experiments.exam.simulate.recordings import simulate_trial
from experiments.exam.simulate.trial import Trial
from rallygap.models.ball.simulators import shipped

NOMINAL = "literature"


def write_recordings(folder, causes=None, shots=60, **settings):
    """Write the recordings of a trial, one file a shot; ``causes`` are hidden in them."""
    trial = Trial("trial", shipped(NOMINAL), causes=causes or {}, shots=shots, **settings)
    folder.mkdir(parents=True)
    for number, recording in enumerate(simulate_trial(trial)[0]):
        rows = pd.DataFrame(recording.positions, columns=list("xyz"))
        rows.insert(0, "t", recording.times)
        if len(recording.labels):
            labels = pd.DataFrame(recording.labels, recording.label_times, ["wx", "wy", "wz"])
            rows = rows.join(labels, on="t")
        rows.to_csv(folder / f"{number:03d}.csv", index=False)
    (folder / "source.yaml").write_text("name: lab\nkind: cannon\n")
    return folder
