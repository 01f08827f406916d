"""The page on the paper: complete, committed as it is printed, and never a zero that is none."""

import json
import shutil
from pathlib import Path

import pytest

from models.predictors.normaliser import INPUTS, OUTPUTS
from models.predictors.transformer import Transformer
from pipeline.experiments.profiles import merged
from pipeline.io.artifacts import write_json
from pipeline.paper.catalogue import EXHIBITS, GROUPS, findings
from pipeline.paper.entries import number
from pipeline.paper.judgements import MEANINGS, NO_NUMBER, NOT_MEASURED, SAME
from pipeline.paper.page import paper_page
from pipeline.paper.run_reports import Reports, laptop_reports, paper_reports
from pipeline.params import read_yaml
from pipeline.runtime.errors import InputError
from pipeline.sweeps.settings import nested

ROOT = Path(__file__).parents[3]
ENTRIES = [entry for group in GROUPS for entry in group.entries]
STAGES = set(read_yaml(ROOT / "dvc.yaml")["stages"])


def test_the_committed_page_is_what_is_printed():
    committed = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    assert committed == paper_page(ROOT) + "\n", "run `rallygap paper > docs/paper.md`"


def test_every_figure_and_table_of_the_paper_has_its_row():
    names = [*(f"Figure {number}" for number in range(1, 6)), "Table I", "Algorithm 1"]
    assert sorted(one.name for one in EXHIBITS) == sorted(names)


def test_what_shows_a_claim_is_there():
    files = [file for one in EXHIBITS if one.claims for file in one.ours.split(", ")]
    assert [file for file in files if not (ROOT / "reports" / "paper" / file).is_file()] == []


@pytest.mark.parametrize(
    ("key", "printed"),
    [
        ("setting.kernel", 3),
        ("setting.stride", 1),
        ("setting.decoder_rows", 12 + 60),
        ("setting.placeholders", "60 x 6 zeros"),
        ("setting.baseline_inputs", 6),
        ("setting.baseline_outputs", 9),
        ("setting.filtered", 12),
        ("setting.judged.first", 100),
        ("setting.judged.last", 300),
        ("setting.judged.every", 5),
    ],
)
def test_numbers_of_the_paper_s_text_have_their_row(key, printed):
    assert next(entry.printed for entry in ENTRIES if entry.key == key) == printed


def test_settings_that_no_parameter_changes_are_those_of_the_network():
    network = Transformer(8, 16, 2, 1, 1, states_a_row=1, uniform_motion=False)
    convolution = network.decoder_embedding.projection
    found = findings(Reports(Path("nowhere"), {}))
    assert convolution.kernel_size == (found["setting.kernel"].value,)
    assert convolution.stride == (found["setting.stride"].value,)
    assert convolution.in_channels == found["setting.inputs"].value == INPUTS
    assert found["setting.baseline_inputs"].value == INPUTS
    assert found["setting.baseline_outputs"].value == found["setting.outputs"].value == OUTPUTS


@pytest.mark.parametrize("states", [1, 10])
def test_rows_of_the_decoder_are_the_network_s(tmp_path, states):
    network = Transformer(8, 16, 2, 1, 1, states_a_row=states, uniform_motion=True)
    settings = {"states_a_row": states, "uniform_motion": True}
    params = {"train_predictor": {"networks": {"transformer": settings}}}
    found = findings(Reports(tmp_path, params))
    assert found["setting.decoder_rows"].value == len(network.decoder_embedding.positions)
    assert found["setting.placeholders"].value == f"{network.rows} rows of uniform motion"


def test_the_kept_run_is_the_profile_that_the_page_names():
    kept = paper_reports(ROOT).params
    assert merged(kept, read_yaml(ROOT / "profiles" / "two_cores.yaml")) == kept


def test_a_run_in_the_paper_s_size_is_not_called_smaller(tmp_path):
    page = kept_page(tmp_path, width=512)
    assert "two_cores" not in page and "has not been run" not in page
    smaller = kept_page(tmp_path, width=96)
    assert "96 of 512 wide (– trained numbers)" in smaller and "has not been run" in smaller


def kept_page(root, width):
    """The page of a repository that keeps a run with networks of a width."""
    shutil.copy(ROOT / "params.yaml", root)
    params = {"train_predictor": {"networks": {"transformer": {"width": width}}}}
    write_json(root / "reports" / "paper" / "run.json", {"params": params})
    return paper_page(root)


def test_every_entry_has_a_key_of_its_own_and_a_stage_that_is_there():
    keys = [entry.key for entry in ENTRIES]
    assert len(set(keys)) == len(keys)
    assert {entry.stage for entry in ENTRIES} - STAGES <= {"–"}
    assert {one.stage for one in EXHIBITS} <= STAGES


def test_without_reports_nothing_is_measured(tmp_path):
    words = {found.verdict for found in findings(Reports(tmp_path, {})).values()}
    constants = {SAME, "differs"}
    assert words == {NOT_MEASURED, NO_NUMBER, *constants}
    drawn = {one.verdict(Reports(tmp_path, {})) for one in EXHIBITS}
    assert drawn == {NOT_MEASURED, NO_NUMBER}


def test_every_verdict_is_explained():
    found = findings(laptop_reports(ROOT)).values()
    assert {one.verdict for one in found} <= set(MEANINGS)


def test_settings_of_the_paper_s_profile_are_the_paper_s(tmp_path):
    for name in ("params.yaml", "profiles/paper.yaml"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    found = findings(paper_reports(tmp_path))  # where no run was kept
    differ = {key for key, one in found.items() if one.verdict == "differs"}
    own = {entry.key for entry in ENTRIES if "params.yaml" in entry.where}
    assert own and differ & own == set()


def test_a_kept_run_is_read_with_its_own_parameters(tmp_path):
    shutil.copy(ROOT / "params.yaml", tmp_path)
    params = {"sim2sim": {"episodes": 77}}
    write_json(tmp_path / "reports" / "paper" / "run.json", {"params": params})
    assert findings(paper_reports(tmp_path))["setting.sim2sim.episodes"].value == 77


@pytest.mark.parametrize("record", [{}, [], 7, {"params": None}, {"params": [1]}])
def test_a_broken_record_of_the_kept_run_is_named(tmp_path, record):
    write_json(tmp_path / "reports" / "paper" / "run.json", record)
    with pytest.raises(InputError, match=r"run\.json, params: .*`rallygap keep`"):
        paper_reports(tmp_path)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("sim2sim.episodes", "many"),
        ("sim2sim.episodes", {}),
        ("ingest.arena.position_noise", "0.003"),
        ("ingest.arena.spin_noise", True),
        ("train_predictor.training", 7),
        ("train_predictor.training.decay", []),
        ("train_predictor.training.matrix_learning_rate", "fast"),
        ("train_predictor.networks.transformer.width", float("nan")),
        ("train_predictor.networks.transformer.states_a_row", 0),
        ("train_predictor.networks.transformer.uniform_motion", "yes"),
        ("train_policy.groups.sim2sim.horizons_ms", 120),
        ("train_policy.groups.sim2sim.horizons_ms", [[120, None]]),
        ("sim2real.simulator", "another"),
    ],
)
def test_a_kept_parameter_of_another_kind_is_named(tmp_path, path, value):
    shutil.copy(ROOT / "params.yaml", tmp_path)
    kept = tmp_path / "reports" / "paper" / "run.json"
    kept.parent.mkdir(parents=True)
    states = {"train_predictor.networks.transformer.states_a_row": 1}
    params = nested({"train_predictor.training.epochs": 80} | states | {path: value})
    kept.write_text(json.dumps({"params": params}))
    with pytest.raises(InputError, match=rf"run\.json, {path}: cannot be told: .*`rallygap keep`"):
        paper_page(tmp_path)


@pytest.mark.parametrize(
    ("file", "content"),
    [
        ("sim2real/rates.csv", ""),
        ("sim2real/replayed.csv", "set,replayed\nreceive,many\n"),
        ("segment/splits.csv", "source,split,group,episodes\narena,train,pro,many\n"),
    ],
)
def test_a_broken_table_is_named(tmp_path, file, content):
    path = tmp_path / file
    path.parent.mkdir()
    path.write_text(content)
    with pytest.raises(InputError, match=rf"{file}: is not a CSV table"):
        findings(Reports(tmp_path, {}))


def test_a_table_without_a_column_does_not_have_its_numbers(tmp_path):
    path = tmp_path / "segment" / "splits.csv"
    path.parent.mkdir()
    path.write_text("source,group,episodes\narena,pro,3\n")
    found = findings(Reports(tmp_path, {}))
    assert found["data.all"].value == 3
    assert found["data.test"].verdict == NOT_MEASURED


@pytest.mark.parametrize(
    ("value", "text"), [(1e-12, "1e-12"), (0.0, "0"), (100_000, "100,000"), (0.05, "0.05")]
)
def test_small_numbers_are_not_zero(value, text):
    assert number(value) == text
