"""The pipeline: stages' parameters, files, runs, results and the command line."""

from rallygap.pipeline.runtime.determinism import hold_arithmetic, is_program

if is_program("rallygap"):
    hold_arithmetic()
