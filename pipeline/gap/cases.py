"""Cases of the gap workflow: shots of a source, a simulator, and the verdict on them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.diagnose import diagnose
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.net.contacts import NetContacts
from rallygap.models.gap.settings import GapSettings
from rallygap.models.gap.verdict import Verdict
from rallygap.pipeline.gap.provenance import made_from
from rallygap.pipeline.gap.shots import SourceShots, shots_of
from rallygap.pipeline.io.amended_simulators import case_name
from rallygap.pipeline.io.episodes import MeasuredEpisode
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.params import CloseGapSettings, ComparedSimulatorSettings
from rallygap.pipeline.runtime.errors import InputError

BOUNCE = "table_bounce"


@dataclass(frozen=True)
class Case:
    """Shots that are compared with a nominal simulator.

    Attributes:
        source: of the shots.
        simulator_name: in the settings.
        split: number of the random draw of shots.
        simulator: the nominal one.
        shots: in the order drawn, which decides which of them are held out.
        nets: all contacts with the net.
        level: probability of a false cause where there is no gap.
    """

    source: str
    simulator_name: str
    split: int
    simulator: Simulator
    shots: Shots
    nets: NetContacts
    level: float

    @property
    def name(self) -> str:
        """Stem of its files' names."""
        return case_name(self.source, self.simulator_name, self.split)

    def diagnose(self) -> "Diagnosed":
        """Return the case with its verdict."""
        settings = GapSettings(level=self.level)
        verdict = diagnose(self.shots, self.simulator, settings, nets=self.nets)
        counts = len(np.unique(self.shots.groups)), len(self.shots)
        name = self.simulator_name
        origin = made_from(self.source, None, counts, self.simulator, name, self.level)
        return Diagnosed(self, verdict.model_copy(update={"made_from": origin}))


@dataclass(frozen=True)
class Diagnosed:
    """A case and its verdict."""

    case: Case
    verdict: Verdict


def cases(
    shots: Mapping[str, SourceShots], settings: CloseGapSettings, seed: int
) -> Iterator[Case]:
    """Yield all cases; a split draws the same shots for every simulator.

    Raises:
        InputError: a simulator cannot be used.
    """
    simulators = {
        name: nominal_simulator(entry, name) for name, entry in settings.simulators.items()
    }
    for source, pool in shots.items():
        for name, simulator in simulators.items():
            for split in range(settings.splits):
                random = np.random.default_rng([seed, split, *source.encode()])
                chosen = drawn(pool.members, settings.shots, random)
                yield Case(source, name, split, simulator, chosen, pool.nets, settings.level)


def nominal_simulator(settings: ComparedSimulatorSettings, name: str) -> Simulator:
    """Return a simulator without the effects that the settings remove.

    Raises:
        InputError: there is no such simulator, it has no such effect, or it has no table.
    """
    effects = load_simulator(settings.simulator).to_dict()
    field = f"close_gap.simulators.{name}"
    for effect in settings.without:
        if effect not in effects:
            problem = f"has no effect {effect} to remove; it has {', '.join(effects)}"
            raise InputError(settings.simulator, problem, field=field)
        del effects[effect]
    if BOUNCE not in effects:
        raise InputError(settings.simulator, f"needs {BOUNCE}: measured balls bounce", field=field)
    return Simulator.from_dict(effects)


def drawn(members: Sequence[MeasuredEpisode], most: int, random: np.random.Generator) -> Shots:
    """Return at most ``most`` episodes as shots, in a random order.

    Recordings are renamed by their order, because held-out recordings are chosen by name and must
    differ between draws.
    """
    order = random.permutation(len(members))[:most]
    chosen = shots_of([members[k] for k in order])
    return replace(chosen, groups=pd.factorize(chosen.groups)[0])
