"""The audit of an engine: its effects with their values, and what no effect explains.

There is no noise, and first states are known. So an effect is not a matter of significance: it is
named if it matters by more than a threshold in millimetres. Effects are added one after the other,
each time the one that leaves least, and all values are fitted again (Gauss and Newton). At the end
those that hardly matter are taken out.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil
from time import monotonic

import numpy as np

from rallygap.models.audit.bounces import Bounces
from rallygap.models.audit.probes import Flown, Probes, bounce_probes, flight_probes, rms
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import SPIN
from rallygap.models.engines.engine import Engine, EngineError
from rallygap.models.gap.hypotheses import Hypothesis, hypotheses
from rallygap.models.gap.types import Phase

# What every engine has; the values are those to begin with.
BASE = Simulator.from_dict(
    {"gravity": {"g": 9.81}, "table_bounce": {"restitution": 0.9, "friction": 0.2}}
)
ALWAYS: dict[Phase, tuple[Hypothesis, ...]] = {
    "flight": (Hypothesis("gravity", "g"),),
    "table": tuple(Hypothesis("table_bounce", name) for name in ("restitution", "friction")),
}
# Parameters that act as those of ALWAYS or as all others together.
NOT_SEPARABLE = ("buoyancy.b", "added_mass.c")
FEW = 8  # probes that are flown together
PATIENCE = 60.0  # s for the probes of a phase, as far as that leaves enough of them
FEWEST = 24  # probes of a phase
SAME_SPIN = 0.01  # relative, of spins that an engine has cut alike
FEWEST_MET = 0.5  # of the bounce probes; with fewer there is no table
FEWEST_BOUNCES = 0.5  # of the bounce probes; with fewer its contact is dead

LEAST = 0.02  # mm, root mean square, that an effect has to remove
ROUNDS = 6  # of Gauss and Newton; flights are nearly linear in the values
CONVERGED = 1e-6  # mm


@dataclass(frozen=True)
class FoundEffect:
    """A parameter that an engine has.

    Attributes:
        hypothesis: the parameter.
        value: in its unit.
        worth_mm: by how much the distance from the engine grows without it, median over probes at
            their last time.
    """

    hypothesis: Hypothesis
    value: float
    worth_mm: float


@dataclass(frozen=True)
class Unexplained:
    """What no effect explains: distances of positions at the last time of the probes of a phase.

    Attributes:
        median_mm: over the probes.
        largest_mm: over the probes.
    """

    median_mm: float
    largest_mm: float


@dataclass(frozen=True)
class Audit:
    """What an engine really does.

    Attributes:
        simulator: the list of effects that comes closest to it.
        effects: of flight, then of the table.
        unexplained: what they do not explain, by phase.
        bounces: contact by contact; None where the engine has no table or a dead contact.
        spin_limit: rad/s, at which the engine cuts spins; infinite where it does not.
        flown: what the engine makes of the probes, by phase; fewer probes where it is slow.
    """

    simulator: Simulator
    effects: tuple[FoundEffect, ...]
    unexplained: dict[Phase, Unexplained]
    bounces: Bounces | None
    spin_limit: float
    flown: dict[Phase, Flown]

    @property
    def has_table(self) -> bool:
        """Whether the engine has a table: most bounce probes lose their downward speed."""
        return "table" in self.unexplained

    @property
    def probes(self) -> dict[Phase, int]:
        """How many were flown, by phase."""
        return {phase: len(flown.probes) for phase, flown in self.flown.items()}


def audit(
    engine: Engine,
    progress: Callable[[float], None] = lambda share: None,
    patience: float = PATIENCE,
) -> Audit:
    """Fly probe shots and find the engine's effects.

    Args:
        engine: to be audited.
        progress: called with the share of the work that is done.
        patience: s for the probes of a phase; infinite for all of them, however slow the machine.

    Raises:
        EngineError: the engine cannot fly the probes.
    """
    flight = _flown(engine, flight_probes(), lambda share: progress(0.5 * share), patience)
    limit = _spin_limit(flight)
    simulator, effects = _effects(flight, BASE)
    unexplained: dict[Phase, Unexplained] = {"flight": _unexplained(flight, simulator)}
    table = _flown(engine, bounce_probes(), lambda share: progress(0.5 + 0.5 * share), patience)
    flown: dict[Phase, Flown] = {"flight": flight, "table": table}
    bounces = Bounces.of(table, simulator)
    if bounces.met.mean() < FEWEST_MET:
        return Audit(simulator.without_surfaces(), effects, unexplained, None, limit, flown)
    simulator, more = _effects(table, simulator)
    unexplained["table"] = _unexplained(table, simulator)
    known = bounces if bounces.bounced.mean() >= FEWEST_BOUNCES else None
    return Audit(simulator, (*effects, *more), unexplained, known, limit, flown)


def _flown(
    engine: Engine, probes: Probes, progress: Callable[[float], None], patience: float
) -> Flown:
    """Fly probes a few at a time; leave some out if the first ones show that all take too long."""
    started = monotonic()
    engine.fly(probes[:FEW].states, probes.times)
    needed = (monotonic() - started) / FEW * len(probes)
    kept = probes[:: max(1, min(ceil(needed / patience), len(probes) // FEWEST))]
    parts = []
    for first in range(0, len(kept), FEW):
        parts.append(engine.fly(kept[first : first + FEW].states, kept.times))
        progress(min((first + FEW) / len(kept), 1.0))
    states = np.concatenate(parts)
    if not np.isfinite(states).all():
        raise EngineError(f"{engine.name} returns numbers that are not finite")
    return Flown(kept, states)


def _spin_limit(flown: Flown) -> float:
    """Return the spin that all faster ones have at all times, if there is one."""
    launched = np.linalg.norm(flown.probes.states[:, SPIN], axis=1)
    spins = np.linalg.norm(flown.states[..., SPIN], axis=-1)
    largest = float(spins.max())
    cut = launched > (1.0 + SAME_SPIN) * largest
    same = np.abs(spins[cut] - largest) <= SAME_SPIN * largest
    return largest if cut.any() and same.all() else np.inf


def _effects(flown: Flown, simulator: Simulator) -> tuple[Simulator, tuple[FoundEffect, ...]]:
    """Return the simulator with the engine's effects of a phase, and these."""
    phase = flown.probes.phase
    always = ALWAYS[phase]
    candidates = [
        hypothesis
        for hypothesis in hypotheses(BASE)
        if hypothesis.phase == phase
        and hypothesis not in always
        and hypothesis.identity not in NOT_SEPARABLE
    ]
    simulator, others = _selected(flown, simulator, always, candidates)
    chosen = [*always, *others]
    left = _unexplained(flown, simulator).median_mm
    effects = []
    for hypothesis in chosen:
        worth = np.nan
        if hypothesis not in always:
            reduced = _without(flown, simulator, chosen, hypothesis)
            worth = _unexplained(flown, reduced).median_mm - left
        effects.append(FoundEffect(hypothesis, hypothesis.value(simulator), worth))
    return simulator, tuple(effects)


def _unexplained(flown: Flown, simulator: Simulator) -> Unexplained:
    distances = flown.distances(simulator)[:, -1]
    return Unexplained(float(np.median(distances)), float(distances.max()))


def _selected(
    flown: Flown, simulator: Simulator, always: Sequence[Hypothesis], candidates: list[Hypothesis]
) -> tuple[Simulator, list[Hypothesis]]:
    """Return the simulator with the values that the engine has, and the candidates that matter.

    Args:
        flown: by the engine.
        simulator: to begin with.
        always: parameters that every engine has.
        candidates: others that it may have.
    """
    simulator = _fitted(flown, simulator, always)
    chosen: list[Hypothesis] = []
    while candidates:
        best = _most_useful(flown, simulator, [*always, *chosen], candidates)
        trial = _fitted(flown, simulator, [*always, *chosen, best])
        if flown.rms(simulator) - flown.rms(trial) < LEAST:
            break
        simulator, chosen = trial, [*chosen, best]
        candidates.remove(best)
    while chosen:
        parameters = [*always, *chosen]
        reduced = {other: _without(flown, simulator, parameters, other) for other in chosen}
        idle = min(chosen, key=lambda other: flown.rms(reduced[other]))
        if flown.rms(reduced[idle]) - flown.rms(simulator) >= LEAST:
            break
        simulator = reduced[idle]
        chosen.remove(idle)
    return simulator, chosen


def _fitted(flown: Flown, simulator: Simulator, parameters: Sequence[Hypothesis]) -> Simulator:
    """Return the simulator with the values of parameters that come closest to the engine."""
    for _ in range(ROUNDS):
        before = flown.residuals(simulator).ravel()
        steps = np.linalg.lstsq(flown.slopes(simulator, parameters), -before, rcond=None)[0]
        values = {
            (hypothesis.effect, hypothesis.parameter): hypothesis.value(simulator) + step
            for hypothesis, step in zip(parameters, steps, strict=True)
        }
        trial = simulator.with_values(values)  # within their bounds
        gain = rms(before) - flown.rms(trial)
        if gain > 0.0:
            simulator = trial
        if gain < CONVERGED:
            break
    return simulator


def _without(
    flown: Flown, simulator: Simulator, parameters: Sequence[Hypothesis], idle: Hypothesis
) -> Simulator:
    """Return the simulator with one parameter neutral and the values of the others fitted again."""
    others = [parameter for parameter in parameters if parameter != idle]
    return _fitted(flown, idle.at(simulator, idle.declaration.neutral), others)


def _most_useful(
    flown: Flown, simulator: Simulator, chosen: Sequence[Hypothesis], left: Sequence[Hypothesis]
) -> Hypothesis:
    """Return the parameter that, to first order, leaves least together with those chosen."""
    here = flown.residuals(simulator).ravel()
    known = np.linalg.qr(flown.slopes(simulator, chosen))[0]
    rest = here - known @ (known.T @ here)
    columns = flown.slopes(simulator, left)
    own = columns - known @ (known.T @ columns)
    sizes = np.linalg.norm(own, axis=0)
    # What is a combination of those chosen adds nothing.
    new = sizes > 1e-3 * np.linalg.norm(columns, axis=0)
    gains = np.where(new, (own.T @ rest) ** 2 / np.maximum(sizes, 1e-12) ** 2, 0.0)
    return left[int(gains.argmax())]
