"""Scripts of the stages of experiments/dvc.yaml."""
