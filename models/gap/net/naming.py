"""Naming the net: whether its restitution and friction differ from the simulator's."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.fit.shots import held_out
from rallygap.models.gap.name.causes import described
from rallygap.models.gap.name.naming import Named
from rallygap.models.gap.net.contacts import NetContacts
from rallygap.models.gap.net.impacts import Impacts
from rallygap.models.gap.net.law import PARAMETERS, NetLaw
from rallygap.models.gap.settings import Question
from rallygap.models.gap.verdict import Cause, NetErrors, Worth
from rallygap.models.gap.verify.bootstrap import interval, resampled, root_mean_squares

EFFECT = "net"


@dataclass(frozen=True)
class NetFinding:
    """What contacts with the net say.

    Attributes:
        causes: restitution and friction, where they differ from the simulator's.
        errors: of predictions of held-out paths after the net.
    """

    causes: tuple[Cause, ...]
    errors: NetErrors


def name_net(contacts: NetContacts, named: Named, question: Question) -> NetFinding | None:
    """Return the causes at the net, given the other causes.

    It is None if contacts are too few or the net is withheld.
    """
    settings = question.settings
    if EFFECT in question.withheld or len(contacts) < settings.net.min_contacts:
        return None
    contacts = contacts.changed(named.corrected)
    held = held_out(contacts.before, settings)
    noise, simulator = named.fit.noise_estimate.noise, named.simulator
    some, others = (
        Impacts.of(contacts[rows], simulator, noise, settings) for rows in (~held, held)
    )
    least = settings.net.min_contacts // settings.verify.held_out
    if len(others) < least or len(some) + len(others) < settings.net.min_contacts:
        return None
    law = NetLaw(some, simulator, settings)
    causes = _causes(law, others, question)
    amended = law.amended if causes else simulator
    return NetFinding(causes, _errors(simulator, amended, len(some), others, question))


def _causes(law: NetLaw, others: Impacts, question: Question) -> tuple[Cause, ...]:
    """Return the parameters that differ, if the law is significantly likelier than the nominal."""
    gain = law.deviance_of(law.simulator) - law.deviance
    p_value = float(chi2.sf(max(gain, 0.0), len(PARAMETERS)))
    if p_value > question.settings.level:
        return ()
    missing = EFFECT not in law.simulator.effects
    found = []
    for k, hypothesis in enumerate(PARAMETERS):
        low, high = law.interval(k)
        if missing or not low <= hypothesis.value(law.simulator) <= high:
            estimate = float(law.estimate[k])
            worth = _worth(law, k, others, question)
            found.append(
                Cause(
                    **described(hypothesis, question.simulator),
                    role="leading" if worth.interval[0] > 0.0 else "minor",
                    estimate=estimate,
                    interval=(min(low, estimate), max(high, estimate)),
                    p_value=p_value,
                    gap_share=0.0,
                    worth=worth,
                    possible=(hypothesis.identity,),
                )
            )
    return tuple(found)


def _worth(law: NetLaw, k: int, others: Impacts, question: Question) -> Worth:
    """Return how much predictions after the net err more with one value as the simulator has it."""
    settings, hypothesis = question.settings, PARAMETERS[k]
    without = law.simulator
    if EFFECT in without.effects:
        without = hypothesis.at(law.amended, hypothesis.value(law.simulator))
    squares = np.stack([others.squares(one, settings) for one in (law.amended, without)])
    drawn = resampled(squares, settings.verify.bootstrap_draws)
    sizes = root_mean_squares(squares)[:, 0]
    growth = 1e3 * (drawn[:, 1] - drawn[:, 0])[:, 0]
    mm = round(1e3 * float(sizes[1] - sizes[0]), 6)
    return Worth(mm=mm, interval=interval(growth, settings.confidence))


def _errors(
    nominal: Simulator, amended: Simulator, named_from: int, others: Impacts, question: Question
) -> NetErrors:
    settings = question.settings
    squares = np.stack([others.squares(one, settings) for one in (nominal, amended)])
    before, after = (round(1e3 * float(size), 3) for size in root_mean_squares(squares)[:, 0])
    return NetErrors(
        contacts=named_from + len(others),
        held_out=len(others),
        horizon_ms=round(1e3 * settings.net.horizon),
        before_mm=before,
        after_mm=after,
    )
