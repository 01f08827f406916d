"""Correct recordings pass the check, whatever physics they have; what is doubtful is said."""

import pandas as pd
import pytest

from rallygap.pipeline.gap.data_check.check import check_recordings
from rallygap.pipeline.gap.measured_shots import read_shots
from rallygap.pipeline.io.frame import Frame
from rallygap.pipeline.io.schemas import POSITION_COLUMNS
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sources.source import RawTable
from tests.pipeline.recorded import write_recordings

# Sizes at or near the bounds of the catalogue; the pairs are the worst for spins and for axes.
LARGE = [
    {"gravity": {"g": 7.0}},
    {"drag": {"cd": 0.9}},
    {"magnus": {"cm": 0.0}},
    {"magnus": {"cm": 0.4}},
    {"magnus": {"cm": 0.33}, "spin_gain": {"s": -0.5}},
    {"lift_saturation": {"kappa": 20.0}, "spin_gain": {"s": 0.5}},
    {"lift_crisis": {"d": 2.0}},
    {"wind": {"x": 3.0, "y": 3.0}},
    {"frame_tilt": {"x": 0.2, "y": 0.2}},
    {"spin_sign_flip": {"share": 0.8}},
    {"clock_rate": {"d": 0.2}, "position_scale": {"s": -0.1}},
    {"table_height": {"h": 0.03}},
]


@pytest.mark.parametrize("causes", LARGE, ids=lambda causes: " ".join(causes))
def test_large_effects_do_not_stop(tmp_path, causes):
    assert len(read_shots(write_recordings(tmp_path / "lab", causes, shots=30), "csv").shots) > 20


@pytest.mark.parametrize(
    ("causes", "settings", "doubt"),
    [
        ({"table_height": {"h": 0.05}}, {}, "bounce at z = 70 mm"),
        ({"table_tilt": {"x": 0.03, "y": 0.03}}, {}, "heights of bounces rise by 4. mm/m"),
        ({"wind": {"z": 5.0}}, {}, "instead of 9.81"),
        ({}, {"time_resolution": 1e-3}, "rounded to 1 ms"),
        ({"spin_sign_flip": {"share": 0.8}}, {}, "curve against their spin labels"),
    ],
)
def test_what_is_doubtful_is_said(tmp_path, causes, settings, doubt):
    folder = write_recordings(tmp_path / "lab", causes, shots=30, **settings)
    assert pd.Series(read_shots(folder, "csv").doubts).str.contains(doubt).any()


def test_correct_recordings_have_no_doubt(tmp_path):
    assert read_shots(write_recordings(tmp_path / "lab", shots=30), "csv").doubts == ()


def test_an_origin_at_a_corner_of_the_table_is_doubtful(tmp_path):
    folder = write_recordings(tmp_path / "lab", shots=30)
    for path in folder.glob("*.csv"):
        rows = pd.read_csv(path)
        rows.assign(x=rows["x"] + 0.7625, y=rows["y"] + 1.37).to_csv(path, index=False)
    assert any("the origin is at" in doubt for doubt in read_shots(folder, "csv").doubts)


def test_a_source_without_source_yaml_is_told_no_line(tmp_path):
    folder = write_recordings(tmp_path / "lab", shots=6)
    columns = ["t", *POSITION_COLUMNS]
    parts = [pd.read_csv(path)[list("txyz")].to_numpy() for path in folder.glob("*.csv")]
    tables = [
        RawTable(str(number), pd.DataFrame(part * [1, 1000, 1000, 1000], columns=columns))
        for number, part in enumerate(parts)
    ]
    with pytest.raises(InputError, match=r"positions are not in m: .*; mm\?$"):
        check_recordings(tables, Frame(), None, tmp_path)


def test_flight_across_the_table_is_doubtful_where_no_bounce_decides(tmp_path):
    folder = write_recordings(tmp_path / "lab", shots=12, spin_labels="none")
    for path in folder.glob("*.csv"):
        rows = pd.read_csv(path).head(35)
        rows.assign(x=rows["y"], y=rows["x"]).to_csv(path, index=False)
    assert any("fly along x" in doubt for doubt in read_shots(folder, "csv").doubts)


@pytest.mark.real
@pytest.mark.parametrize("source", ["spindoe", "tt3d", "isr_ball_prediction"])
def test_measured_sets_pass(real_data, source):
    assert len(read_shots(real_data / source, source).shots) > 50
