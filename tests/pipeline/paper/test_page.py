"""The page on the paper: complete, and its settings those of the run and of the code."""

from pathlib import Path

import pytest

from experiments.report.paper_page import paper_page
from rallygap.models.predictors.errors import HORIZONS_MS
from rallygap.models.predictors.normaliser import INPUTS, OUTPUTS
from rallygap.models.predictors.protocol import FUTURE, HISTORY, TICK
from rallygap.models.predictors.transformer import Transformer
from rallygap.pipeline.io.artifacts import write_json, write_text
from rallygap.pipeline.paper.assessments import DIFFERS, MEANINGS, NOT_MEASURED
from rallygap.pipeline.paper.comparison import compare, exhibits, groups
from rallygap.pipeline.paper.run_reports import Reports, kept_reports, laptop_reports
from rallygap.pipeline.paper.values import printed_values
from rallygap.pipeline.params import read_yaml
from rallygap.pipeline.profiles import profile_params
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.sweeps.settings import nested
from tests.stage_files import outputs, paths

ROOT = Path(__file__).parents[3]
VALUES = printed_values()
STAGES = set(read_yaml(ROOT / "dvc.yaml")["stages"])


def test_every_value_has_its_own_id_and_a_stage_that_exists():
    assert len({value.id for value in VALUES}) == len(VALUES)
    assert {value.stage for value in VALUES} - {""} <= STAGES
    assert {value.group for value in VALUES} == {group.id for group in groups()}
    assert {one.stage for one in exhibits()} <= STAGES


def test_the_page_has_the_files_of_every_figure_and_table_with_an_assessment():
    found = compare(laptop_reports(ROOT)).values()
    assert {one.assessment for one in found} <= set(MEANINGS)
    report = read_yaml(ROOT / "dvc.yaml")["stages"]["report"]
    made = {path.removeprefix("reports/") for path in paths(outputs(report))}
    files = {file for one in exhibits() if one.claims for file in one.ours.split(", ")}
    assert {file for file in files if not {file, str(Path(file).parent)} & made} <= STAGES
    tables = [ROOT / "reports/paper" / file for file in files if file.endswith(".csv")]
    assert [path.name for path in tables if not path.is_file()] == []


def test_the_committed_page_follows_from_the_committed_reports():
    assert (ROOT / "docs" / "paper.md").read_text("utf-8") == paper_page(ROOT)


def test_settings_that_no_parameter_changes_are_those_of_the_network():
    network = Transformer(8, 16, 2, 1, 1, states_per_row=1, uniform_motion=False)
    convolution = network.decoder_embedding.projection
    found = compare(Reports(Path("nowhere"), {}))
    assert convolution.kernel_size == (found["setting.kernel"].value,)
    assert convolution.stride == (found["setting.stride"].value,)
    assert convolution.in_channels == found["setting.inputs"].value == INPUTS
    named = [found[f"setting.{name}"].value for name in ("outputs", "history", "future", "tick")]
    assert named == [OUTPUTS, HISTORY, FUTURE, 1000 * TICK]
    horizons = [found[f"setting.judged.{name}"].value for name in ("first", "last", "every")]
    assert horizons == [HORIZONS_MS[0], HORIZONS_MS[-1], HORIZONS_MS[1] - HORIZONS_MS[0]]


@pytest.mark.parametrize("states", [1, 10])
def test_rows_of_the_decoder_are_the_networks(tmp_path, states):
    network = Transformer(8, 16, 2, 1, 1, states_per_row=states, uniform_motion=True)
    settings = {"states_per_row": states, "uniform_motion": True}
    params = {"train_predictor": {"networks": {"transformer": settings}}}
    found = compare(Reports(tmp_path, params))
    assert found["setting.decoder_rows"].value == len(network.decoder_embedding.positions)
    assert found["setting.placeholders"].value == f"{network.rows} rows of uniform motion"


def test_settings_of_the_papers_profile_are_the_papers(tmp_path):
    params = profile_params(ROOT, "paper_network").model_dump(mode="json")
    found = compare(Reports(tmp_path, params))
    differ = {key for key, ours in found.items() if ours.assessment == DIFFERS}
    settings = {value.id for value in VALUES if "params.yaml" in value.ours}
    assert settings and differ & settings == set()


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("train_predictor.training", 7),
        ("train_predictor.networks.transformer.states_per_row", 0),
        ("train_policy.groups.sim2sim.horizons_ms", [120, None]),
        ("sim2real.simulator", "another"),
    ],
)
def test_a_kept_parameter_of_the_wrong_type_is_named(tmp_path, path, value):
    states = {"train_predictor.networks.transformer.states_per_row": 1}
    params = nested({"train_predictor.training.epochs": 80} | states | {path: value})
    write_json(tmp_path / "params.json", params)
    with pytest.raises(InputError, match=rf"params\.json, params\.yaml: {path}"):
        compare(kept_reports(tmp_path))
    write_json(tmp_path / "params.json", [1])
    with pytest.raises(InputError, match=r"params\.json: holds no parameters"):
        kept_reports(tmp_path)


@pytest.mark.parametrize("content", ["", "source,split,group,episodes\narena,train,pro,many\n"])
def test_a_broken_table_is_named_and_one_without_a_column_lacks_its_numbers(tmp_path, content):
    write_text(tmp_path / "segment/splits.csv", content)
    with pytest.raises(InputError, match=r"segment/splits\.csv: is not a CSV table"):
        compare(Reports(tmp_path, {}))
    write_text(tmp_path / "segment/splits.csv", "source,group,episodes\narena,pro,3\n")
    found = compare(Reports(tmp_path, {}))
    assert found["data.all"].value == 3
    assert found["data.test"].assessment == NOT_MEASURED
