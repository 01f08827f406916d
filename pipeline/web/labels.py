"""What predictors, simulators, methods and causes are called in figures and tables."""

from rallygap.models.gap.types import Phase

PREDICTORS = {
    "physics_c": "physics, simulator C",
    "physics_c_with_net": "physics, simulator C with a net",
    "physics_literature": "physics, literature",
    "filterpy_c": "physics, simulator C, filterpy's filter",
    "amended_imperfect_c": "physics, C amended",
    "amended_imperfect_c_without_net": "physics, C amended, its net left out",
    "amended_without_magnus": "physics, C without lift amended",
    "amended_without_magnus_without_net": "physics, C without lift amended, its net left out",
    "amended_from_literature": "physics, literature amended",
    "amended_from_literature_without_net": "physics, literature amended, its net left out",
    "oracle": "oracle",
    "hybrid": "hybrid",
    "hybrid_fine_tuned": "hybrid, fine-tuned",
    "transformer": "transformer",
    "transformer_paper_size": "transformer of the paper's size, random weights",
    "transformer_fine_tuned": "transformer, fine-tuned",
    "tae": "TAE",
    "tae_fine_tuned": "TAE, fine-tuned",
    "gru_tae": "GRU-TAE",
    "gru_tae_fine_tuned": "GRU-TAE, fine-tuned",
    # Of policies: physics with the simulator that they were trained in.
    "physics": "physics, own simulator",
    "amended": "physics, own simulator amended",
}
SIMULATORS = {
    "ground_truth": "ground truth",
    "imperfect_a": "simulator A",
    "imperfect_b": "simulator B",
    "imperfect_c": "simulator C",
    "without_magnus": "simulator C without lift",
    "from_literature": "literature",
}
KIND_NAMES = {"wrong_value": "wrong value", "missing_effect": "missing effect"}
PLACES: dict[Phase, str] = {
    "flight": "in flight",
    "table": "at the table",
    "sensor": "in the measurement",
}


def predictor_label(name: str) -> str:
    """Return what a predictor is called in a figure."""
    return PREDICTORS.get(name, name.replace("_", " ")).removeprefix("physics, ")


def simulator_label(name: str) -> str:
    """Return what a simulator is called in a figure."""
    return SIMULATORS.get(name, name.replace("_", " "))
