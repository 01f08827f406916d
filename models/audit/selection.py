"""Which effects an engine has: those that bring a simulator's flights closer to it.

There is no noise, and first states are known. So an effect is not a matter of significance: it is
named if it matters by more than a threshold in millimetres. Effects are added one after the other,
each time the one that leaves least, and all values are fitted again (Gauss and Newton). At the end
those that hardly matter are taken out.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rallygap.models.audit.probes import Probes
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import POSITION, SPIN
from rallygap.models.ball.types import Floats
from rallygap.models.gap.hypotheses import Hypothesis

MM = 1e3  # in a metre
MM_PER_SPIN = 0.2  # mm that a rad/s counts as; about its Magnus effect on the rest of a flight
LEAST = 0.02  # mm, root mean square, that an effect has to remove
ROUNDS = 6  # of Gauss and Newton; flights are nearly linear in the values
CONVERGED = 1e-6  # mm


@dataclass(frozen=True)
class Flown:
    """Flights of probe shots by an engine.

    Attributes:
        probes: the B shots.
        states: (B, T, 9) of the engine.
    """

    probes: Probes
    states: Floats

    def residuals(self, simulator: Simulator) -> Floats:
        """Return (B, T, 6) differences of a simulator's positions, mm, and of its scaled spins."""
        own = simulator.fly(self.probes.states, self.probes.times).states
        away = own - self.states
        positions, spins = MM * away[..., POSITION], MM_PER_SPIN * away[..., SPIN]
        return np.concatenate([positions, spins], axis=-1)

    def rms(self, simulator: Simulator) -> float:
        """Return the root mean square of the residuals of a coordinate, mm."""
        return _rms(self.residuals(simulator))

    def distances(self, simulator: Simulator) -> Floats:
        """Return (B, T) distances of a simulator's positions, mm."""
        distances: Floats = np.linalg.norm(self.residuals(simulator)[..., :3], axis=-1)
        return distances

    def slopes(self, simulator: Simulator, parameters: Sequence[Hypothesis]) -> Floats:
        """Return (B T 6, P) derivatives of the residuals, flattened, by parameters."""
        here, columns = self.residuals(simulator), []
        for parameter in parameters:
            near = parameter.nearby(simulator)
            change = self.residuals(parameter.at(simulator, near)) - here
            columns.append((change / (near - parameter.value(simulator))).ravel())
        return np.stack(columns, axis=-1)


def selected(
    flown: Flown,
    simulator: Simulator,
    always: Sequence[Hypothesis],
    candidates: Sequence[Hypothesis],
) -> tuple[Simulator, tuple[Hypothesis, ...]]:
    """Return the simulator with the values that the engine has, and the parameters that matter.

    Args:
        flown: by the engine.
        simulator: to begin with.
        always: parameters that every engine has.
        candidates: others that it may have.
    """
    simulator, chosen, left = fitted(flown, simulator, always), list(always), list(candidates)
    while left:
        best = _most_useful(flown, simulator, chosen, left)
        trial = fitted(flown, simulator, [*chosen, best])
        if flown.rms(simulator) - flown.rms(trial) < LEAST:
            break
        simulator, chosen = trial, [*chosen, best]
        left.remove(best)
    return _without_idle(flown, simulator, always, chosen[len(always) :])


def fitted(flown: Flown, simulator: Simulator, parameters: Sequence[Hypothesis]) -> Simulator:
    """Return the simulator with the values of parameters that come closest to the engine."""
    for _ in range(ROUNDS):
        before = flown.residuals(simulator).ravel()
        slopes = flown.slopes(simulator, parameters)
        steps = np.linalg.lstsq(slopes, -before, rcond=None)[0]
        trial = _at_all(simulator, parameters, np.asarray(steps, dtype=np.float64))
        gain = _rms(before) - flown.rms(trial)
        if gain > 0.0:
            simulator = trial
        if gain < CONVERGED:
            break
    return simulator


def without(
    flown: Flown, simulator: Simulator, parameters: Sequence[Hypothesis], idle: Hypothesis
) -> Simulator:
    """Return the simulator with one parameter neutral and the values of the others fitted again."""
    others = [parameter for parameter in parameters if parameter != idle]
    return fitted(flown, idle.at(simulator, idle.declaration.neutral), others)


def _most_useful(
    flown: Flown, simulator: Simulator, chosen: Sequence[Hypothesis], left: Sequence[Hypothesis]
) -> Hypothesis:
    """Return the parameter that, to first order, leaves least together with those chosen."""
    here = flown.residuals(simulator).ravel()
    known = np.linalg.qr(flown.slopes(simulator, chosen))[0] if chosen else np.zeros((len(here), 0))
    rest = here - known @ (known.T @ here)
    columns = flown.slopes(simulator, left)
    own = columns - known @ (known.T @ columns)
    sizes = np.linalg.norm(own, axis=0)
    # What is a combination of those chosen adds nothing.
    new = sizes > 1e-3 * np.linalg.norm(columns, axis=0)
    gains = np.where(new, (own.T @ rest) ** 2 / np.maximum(sizes, 1e-12) ** 2, 0.0)
    return left[int(gains.argmax())]


def _without_idle(
    flown: Flown, simulator: Simulator, always: Sequence[Hypothesis], chosen: list[Hypothesis]
) -> tuple[Simulator, tuple[Hypothesis, ...]]:
    """Take out, one after the other, parameters without which the residual hardly grows."""
    while chosen:
        parameters = [*always, *chosen]
        reduced = {other: without(flown, simulator, parameters, other) for other in chosen}
        idle = min(chosen, key=lambda other: flown.rms(reduced[other]))
        if flown.rms(reduced[idle]) - flown.rms(simulator) >= LEAST:
            break
        simulator = reduced[idle]
        chosen.remove(idle)
    return simulator, (*always, *chosen)


def _at_all(simulator: Simulator, parameters: Sequence[Hypothesis], steps: Floats) -> Simulator:
    """Return the simulator with values changed by steps, within their bounds."""
    return simulator.with_values(
        {
            (one.effect, one.parameter): one.value(simulator) + step
            for one, step in zip(parameters, steps, strict=True)
        }
    )


def _rms(residuals: Floats) -> float:
    return float(np.sqrt(np.mean(residuals**2)))
