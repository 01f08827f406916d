"""Traps: what simulators of table tennis often have without their users' knowledge."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rallygap.models.audit.audit import Audit
from rallygap.models.audit.bounces import SHELL, SOLID
from rallygap.models.audit.probes import flight_probes
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.simulators import shipped
from rallygap.models.ball.state import POSITION
from rallygap.models.gap.hypotheses import Hypothesis

LITERATURE = shipped("literature")
DRAG, LIFT = Hypothesis("drag", "cd"), Hypothesis("magnus", "cm")
LARGEST_LIFT = 0.35  # C_M, beyond all that balls have shown
SCATTER = 0.01  # standard deviation of the restitution about its law
SAME_GRIP = 0.03  # share, by which a grip may differ from that of a sphere
MM = 1e3


@dataclass(frozen=True)
class Trap:
    """A trap.

    Attributes:
        identifier: short, for programs.
        sentence: what the engine does.
        cost_mm: distance of a flight after 0.4 s from one with the literature's value, median over
            the flight probes; None where it is not a matter of flight.
    """

    identifier: str
    sentence: str
    cost_mm: float | None = None


def traps(audit: Audit) -> tuple[Trap, ...]:
    """Return the traps in what an engine does."""
    return (*_of_flight(audit), *_of_table(audit))


def _of_flight(audit: Audit) -> Iterator[Trap]:
    simulator = audit.simulator
    if audit.spin_limit < np.inf:
        sentence = f"Spins are cut at {audit.spin_limit:.0f} rad/s; balls have several hundred."
        yield Trap("spin_limit", sentence)
    if DRAG.value(simulator) == 0.0:
        sentence = "There is no drag: the ball flies in a vacuum."
        yield Trap("no_drag", sentence, _cost(simulator, DRAG))
    lift = LIFT.value(simulator)
    if lift == 0.0:
        yield Trap("no_lift", "Spin does not bend the path.", _cost(simulator, LIFT))
    if lift < 0.0:
        sentence = f"Lift is inverse (C_M {lift:.3g}): topspin lifts the ball."
        yield Trap("inverse_lift", sentence, _cost(simulator, LIFT))
    if lift > LARGEST_LIFT:
        sentence = f"Lift is several times that of a real ball (C_M {lift:.3g})."
        yield Trap("large_lift", sentence, _cost(simulator, LIFT))


def _of_table(audit: Audit) -> Iterator[Trap]:
    bounces = audit.bounces
    if bounces is None and audit.has_table:
        sentence = "The contact is dead: balls sink into the table, or stay on it."
        yield Trap("dead_contact", sentence)
    elif bounces is None:
        yield Trap("no_table", "Balls do not bounce: there is no table where z is zero.")
    if bounces is None:
        return
    if bounces.restitution_scatter > SCATTER:
        low, high = np.nanmin(bounces.restitution), np.nanmax(bounces.restitution)
        yield Trap(
            "restitution_scatters",
            f"The restitution scatters from bounce to bounce, between {low:.2f} and {high:.2f}.",
        )
    grip = float(np.nanmax(bounces.grip))
    if abs(grip / SOLID - 1.0) < SAME_GRIP:
        yield Trap(
            "solid_sphere",
            "The ball is a solid sphere: where slip ends, velocity changes by 2/7 of it, not 2/5.",
        )
    elif grip < (1.0 - SAME_GRIP) * SOLID:
        ended = 100 * grip / SHELL
        sentence = f"The ball never rolls: a contact ends at most {ended:.0f} % of the slip."
        yield Trap("never_rolls", sentence)
    elif grip > (1.0 + SAME_GRIP) * SHELL:
        reversed_ = 100 * (grip / SHELL - 1)
        sentence = (
            f"The table gives tangential energy back: it reverses {reversed_:.0f} % of the slip."
        )
        yield Trap("elastic_grip", sentence)


def _cost(simulator: Simulator, parameter: Hypothesis) -> float:
    probes = flight_probes()
    right = parameter.at(simulator, parameter.value(LITERATURE))
    own, other = (law.fly(probes.states, probes.times).states for law in (simulator, right))
    away = np.linalg.norm((own - other)[:, -1, POSITION], axis=-1)
    return float(MM * np.median(away))
