"""Lists that MuJoCo has no attributes for: does the export name what it cannot write?"""

from collections.abc import Mapping

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.pipeline.simulator_scenes.plain_scene import Kind
from rallygap.pipeline.simulator_scenes.random_lists import (
    BASE,
    FRICTION,
    WITHOUT_ATTRIBUTE,
    Effects,
    complete_list,
    some_effects,
)

LISTS = 40
SCENE = Kind(LISTS, 1e-3)  # nothing is audited, so its contact may be soft


def named_of(number: int) -> dict[str, bool]:
    """Return whether the export names each parameter without attribute of a random list."""
    random = np.random.default_rng(number)
    extra = some_effects(random, complete_list(random, WITHOUT_ATTRIBUTE))
    said = " ".join(unsaid_of(complete_list(random, {**BASE, **FRICTION}) | extra))
    return {
        f"{effect}.{name}": f"{effect}.{name} " in said
        for effect, values in extra.items()
        for name in values
    }


def unsaid_of(effects: Effects) -> list[str]:
    """Return what the export says of a list that it cannot write as a whole, in sentences.

    Raises:
        InputError: the scene cannot be patched.
    """
    from rallygap.pipeline.engines.export.scene.shots import VerificationShots
    from rallygap.pipeline.engines.export.scene.unsaid import unsaid

    after = Simulator.from_dict(effects)
    scene = SCENE.written(effects).scene
    return list(unsaid(scene, SCENE.before(), after, VerificationShots.of(after)))


def named_summary(found: Mapping[str, Mapping[str, bool]]) -> dict[str, dict[str, int]]:
    """Return in how many lists each parameter is, and in how many of them it is named."""
    counts: dict[str, dict[str, int]] = {}
    for one in found.values():
        for name, named in one.items():
            count = counts.setdefault(name, {"lists": 0, "named": 0})
            count["lists"] += 1
            count["named"] += named
    return dict(sorted(counts.items()))
