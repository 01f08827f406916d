"""A verdict's file says what the verdict was made from."""

from dataclasses import replace
from importlib.metadata import version

from rallygap.models.ball.simulators import shipped
from rallygap.models.gap.settings import DEFAULTS, GapSettings
from rallygap.pipeline.gap.provenance import made_from


def test_of_a_path_only_the_name_is_kept():
    simulator = shipped("literature")
    found = made_from("lab", "takes", (3, 40), simulator, "/home/me/sim.yaml", DEFAULTS)
    assert (found.simulator, found.data, found.folder) == ("sim.yaml", "lab", "takes")
    assert (found.recordings, found.shots) == (3, 40)
    assert found.effects == simulator.to_dict()
    assert found.version == version("rallygap")


def test_settings_are_the_level_and_what_differs_from_the_default():
    def settings_of(settings):
        return made_from("lab", None, (3, 40), shipped("literature"), "mine", settings).settings

    assert settings_of(GapSettings()) == {"level": DEFAULTS.level}
    changed = replace(DEFAULTS, level=0.01, fit=replace(DEFAULTS.fit, refit_steps=9))
    assert settings_of(changed) == {"level": 0.01, "fit.refit_steps": 9}
