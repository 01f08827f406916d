"""The sealed truth comes back as the path that was flown."""

import json

import numpy as np
import pytest

from rallygap.models.arena.recording import TrueContacts
from rallygap.models.predictors.protocol import FUTURE_TIMES
from rallygap.pipeline.evaluation.evaluation_windows import read_test_sets
from rallygap.pipeline.io.ground_truth import net_contacts, read_contacts, read_truth, true_windows
from rallygap.pipeline.runtime.errors import InputError
from tests.pipeline.measured_shots import NOISE, SIMULATOR, write_inputs


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    """Simulated shots."""
    made = tmp_path_factory.mktemp("arena")
    write_inputs(made, sources=("arena",))
    return made


@pytest.fixture(scope="module")
def shots(root):
    """Their windows, measured and true."""
    artifacts = root / "artifacts"
    measured = read_test_sets(artifacts, every=0.05)[0]
    truth = read_truth(artifacts / "ingest" / "truth.json")
    contacts = read_contacts(artifacts / "ingest" / "true_contacts.parquet", measured.recordings)
    return measured, true_windows(measured.windows, measured.recordings, truth, contacts)


def test_the_true_future_is_flown_through_the_bounce(shots):
    measured, true = shots
    first = measured.recordings == "arena/cannon/0"
    anchors = measured.windows.anchors[first]
    ball = [0.0, 1.3, 0.3, 0.2, -8.0, 0.5, -150.0, 10.0, 5.0]
    flown = SIMULATOR.fly(np.tile(ball, (len(anchors), 1)), anchors[:, None] + FUTURE_TIMES).states
    known = true.measured[first]
    np.testing.assert_allclose(true.future[first][known], flown[known], atol=1e-6)
    assert measured.windows.bounced[first].any()


def test_true_and_measured_windows_are_the_same_but_for_the_noise(shots):
    measured, true = shots
    np.testing.assert_array_equal(true.measured, measured.windows.measured)
    difference = (true.future - measured.windows.future)[..., :3][true.measured[..., :3]]
    assert difference.std() == pytest.approx(NOISE, rel=0.1)


def test_windows_with_net_contact_are_those_whose_forecast_reaches_it(shots):
    windows, recordings = shots[0].windows, shots[0].recordings
    kinds, met = np.array(["launch", "net", "table"]), 0.4
    contacts = {
        "arena/pro/2": TrueContacts(np.array([0.0, met, met + 0.1]), kinds, np.empty((3, 9)))
    }
    expected = (windows.anchors < met) & (windows.anchors >= met - 0.3)
    expected &= recordings == "arena/pro/2"
    assert 0 < expected.sum() < (recordings == "arena/pro/2").sum()
    np.testing.assert_array_equal(net_contacts(windows, recordings, contacts), expected)


@pytest.mark.parametrize("broken", [{"simulator": {}}, {"simulator": {"gravitas": {}}}, []])
def test_a_broken_truth_is_an_error_that_names_the_file(tmp_path, broken):
    path = tmp_path / "truth.json"
    path.write_text(json.dumps(broken))
    with pytest.raises(InputError, match=r"truth\.json: is not the truth of an arena"):
        read_truth(path)
