"""What is measured about rallygap: the pipeline of experiments/dvc.yaml. It is not installed."""

from rallygap.pipeline.runtime.determinism import hold_arithmetic

hold_arithmetic()  # before numpy is loaded
