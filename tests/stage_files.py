"""What the stages of a dvc.yaml list."""

from itertools import chain


def paths(listed):
    """The paths of dependencies or outputs, with and without settings."""
    return [one if isinstance(one, str) else next(iter(one)) for one in listed]


def outputs(stage):
    """The outputs, metrics and plots of a stage, as dvc.yaml lists them."""
    return [*chain(*(stage.get(kind, []) for kind in ("outs", "metrics", "plots")))]
