"""Experiments that are killed."""

import pytest


def kill_at(module, step, experiment, run):
    """Run an experiment that is killed when a function of its module is called: no reports yet."""

    def killed(*_):
        raise KeyboardInterrupt

    with pytest.MonkeyPatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(module, step, killed)
        experiment(run)
    assert not run.report(".").exists()
