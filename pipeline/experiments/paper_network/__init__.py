"""The paper's network, trained on a GPU."""
