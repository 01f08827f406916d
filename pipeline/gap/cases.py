"""Cases of the gap workflow: shots of a source, a simulator, and the verdict on them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from models.ball.simulator import Simulator
from models.gap.amend.simulator import amended
from models.gap.diagnose import diagnose
from models.gap.fit.shots import Shots
from models.gap.verdict import Verdict
from pipeline.gap.shots import shots_of
from pipeline.io.amended_simulators import case_name
from pipeline.io.episodes import MeasuredEpisode
from pipeline.io.simulators import load_simulator
from pipeline.params import CloseGapSettings, ComparedSimulatorSettings
from pipeline.runtime.errors import InputError
from pipeline.runtime.parallel import parallel
from pipeline.runtime.progress import progress_bar

BOUNCE = "table_bounce"


@dataclass(frozen=True)
class Case:
    """Shots that are compared with a simulator.

    Attributes:
        source: of the shots.
        begun: name of the simulator.
        split: which drawing of the shots.
        simulator: that they are compared with.
        shots: in the order drawn, which decides which of them are kept from naming.
        level: chance of a false name where there is no gap.
    """

    source: str
    begun: str
    split: int
    simulator: Simulator
    shots: Shots
    level: float

    @property
    def name(self) -> str:
        """What its files are called."""
        return case_name(self.source, self.begun, self.split)

    def diagnosed(self) -> "Diagnosed":
        """Return what the shots say of the simulator."""
        return Diagnosed(self, diagnose(self.shots, self.simulator, self.level))


@dataclass(frozen=True)
class Diagnosed:
    """A case and its verdict."""

    case: Case
    verdict: Verdict

    @property
    def amended(self) -> Simulator:
        """The simulator with the causes in it."""
        return amended(self.case.simulator, self.verdict)


def cases(
    shots: Mapping[str, Sequence[MeasuredEpisode]], settings: CloseGapSettings, seed: int
) -> Iterator[Case]:
    """Yield all cases; a split draws the same shots for every simulator.

    Args:
        shots: of every source, by its name.
        settings: the simulators, and how shots are drawn.
        seed: of the drawing.

    Raises:
        InputError: a simulator cannot be used.
    """
    simulators = {name: compared(one, name) for name, one in settings.simulators.items()}
    for source, members in shots.items():
        for name, simulator in simulators.items():
            for split in range(settings.splits):
                random = np.random.default_rng([seed, split, *source.encode()])
                chosen = drawn(members, settings.shots, random)
                yield Case(source, name, split, simulator, chosen, settings.level)


def compared(settings: ComparedSimulatorSettings, name: str) -> Simulator:
    """Return a simulator less the effects that are taken out of it.

    Raises:
        InputError: there is no such simulator, it has no such effect, or balls fall through its
            table.
    """
    effects = load_simulator(settings.simulator).to_dict()
    field = f"close_gap.simulators.{name}"
    for effect in settings.without:
        if effect not in effects:
            problem = f"cannot go without {effect}; it has {', '.join(effects)}"
            raise InputError(settings.simulator, problem, field=field)
        del effects[effect]
    if BOUNCE not in effects:
        raise InputError(settings.simulator, f"needs {BOUNCE}: measured balls bounce", field=field)
    return Simulator.from_dict(effects)


def drawn(members: Sequence[MeasuredEpisode], most: int, random: np.random.Generator) -> Shots:
    """Return episodes as shots in a random order, at most so many.

    Recordings are called by the order in which they come: those that are kept from naming are
    chosen by name, and are others in every drawing.
    """
    order = random.permutation(len(members))[:most]
    chosen = shots_of([members[k] for k in order])
    return replace(chosen, groups=pd.factorize(chosen.groups)[0])


def diagnose_all(chosen: Sequence[Case]) -> list[Diagnosed]:
    """Return the verdicts on all cases, in their order, found side by side."""
    found: list[Diagnosed] = []
    with progress_bar("verdicts", len(chosen)) as advance:
        for one in parallel([case.diagnosed for case in chosen]):
            found.append(one)
            advance()
    return found
