"""The experiment pipeline: stages' parameters, files, runs, results and the command line."""

from rallygap.pipeline.runtime.determinism import hold_arithmetic

hold_arithmetic()
