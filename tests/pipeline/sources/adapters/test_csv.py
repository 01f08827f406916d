"""Own recordings in csv files."""

import numpy as np
import pytest

from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.sources.made_up import PATH, SPIN, TIMES, lines, read, write_csv


def test_a_file_is_a_recording(tmp_path):
    write_csv(tmp_path, "monday.csv")
    write_csv(tmp_path, "tuesday.csv")
    recordings = read(tmp_path, "csv").recordings
    assert recordings["recording_id"].unique().tolist() == ["csv/monday", "csv/tuesday"]
    assert np.array_equal(recordings[["t", *POSITION_COLUMNS]][:4], np.column_stack([TIMES, PATH]))
    assert np.array_equal(recordings[SPIN_COLUMNS], np.tile(SPIN, (8, 1)))


@pytest.mark.parametrize("header", ["t,x,y,z", "t, x, y, z", "\ufefft,x,y,z"])
def test_spin_may_be_left_out(tmp_path, header):
    write_csv(tmp_path, rows=[header, *lines(",", TIMES, PATH)])
    gathered = read(tmp_path, "csv")
    assert gathered.recordings[SPIN_COLUMNS].isna().all(axis=None)
    assert gathered.manifest.sources["csv"].spin == "none"


def test_an_empty_spin_is_no_label_and_half_of_one_is_refused(tmp_path):
    spins = (",,", "1,2,3", "nan,NaN,", "1,,3")
    rows = [f"0.0{number},0,1,0.3,{spin}" for number, spin in enumerate(spins)]
    write_csv(tmp_path, rows=["t,x,y,z,wx,wy,wz", *rows])
    gathered = read(tmp_path, "csv")
    record = gathered.manifest.sources["csv"]
    assert gathered.recordings["wx"].isna().tolist() == [True, False, True, True]
    assert list(record.labels_refused) == ["spin incomplete"]
    assert record.labels_refused["spin incomplete"].rows == {"session.csv": [5]}
    assert record.spin == "per_sample"


def test_source_yaml_states_units_and_axes_and_then_the_frame(tmp_path):
    # After units and axes, table x is the source's y, and table y is its -x.
    settings = """
        units: {position: mm, time: ms, spin: -deg/s}
        axes: [x, z, y]
        frame: {rotation: [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], offset: [0, 2, -0.76]}
        """
    rows = ["t,x,y,z,wx,wy,wz", "5,100,1060,500,9000,-60,90", "10,100,1060,500,,,"]
    write_csv(tmp_path, rows=rows, settings=settings)
    gathered = read(tmp_path, "csv")
    recordings = gathered.recordings
    assert recordings["t"].tolist() == [0.005, 0.01]
    first = recordings.iloc[0]
    assert first[POSITION_COLUMNS].tolist() == pytest.approx([0.5, 1.9, 0.3])
    spin = [-np.pi / 2, 50 * np.pi, np.pi / 3]
    assert first[SPIN_COLUMNS].tolist() == pytest.approx(spin)
    assert recordings["wx"].isna().tolist() == [False, True]
    # 9000 is plausible in its unit.
    assert gathered.manifest.sources["csv"].labels_refused == {}


def test_source_yaml_names_and_describes_the_source(tmp_path):
    write_csv(tmp_path, settings="{name: lab_b, kind: cannon, rate: 143, licence: CC0}")
    gathered = read(tmp_path, "csv")
    record = gathered.manifest.sources["lab_b"]
    assert (record.kind, record.licence, record.stated_rate_hz) == ("cannon", "CC0", 143)
    assert gathered.recordings["recording_id"].iloc[0] == "lab_b/session"
    assert [entry.file for entry in record.files] == ["source.yaml", "session.csv"]


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("colour: red", "colour"),
        ("rate: fast", "rate"),
        ("rate: -1", "rate"),
        ("rate: .inf", "rate"),
        ("name: Lab B", "name"),
        ("kind: launches", "kind"),
        ("frame: {rotation: [[1, 0, 0], [0, 1, 0], [0, 0, -1]]}", "frame"),
        ("frame: {offset: [0, 0]}", "frame.offset"),
        ("units: {position: km}", "units.position"),
        ("units: {length: mm}", "units.length"),
        ("axes: [x, y]", "axes"),
        ("axes: [x, y, y]", "axes"),
        ("[1, 2]", ""),
    ],
)
def test_a_source_yaml_that_says_nonsense_is_one_error(tmp_path, text, field):
    write_csv(tmp_path, settings=text)
    with pytest.raises(InputError, match=rf"source\.yaml.*{field}"):
        read(tmp_path, "csv")


def test_an_own_source_cannot_take_the_name_of_another(tmp_path):
    write_csv(tmp_path, settings="name: arena")
    with pytest.raises(InputError, match="two sources are called arena"):
        read(tmp_path, "arena", "csv")
