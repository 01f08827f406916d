"""Roles: worth is a difference of prediction errors, and what is not needed is minor."""

from dataclasses import replace

import numpy as np
import pytest

from rallygap.models.gap.fit.refit import refit
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.name.label_readings import all_as_read
from rallygap.models.gap.name.naming import Named, without_cause
from rallygap.models.gap.name.selection import Explainer, best_explanation, evidence_about
from rallygap.models.gap.settings import Question
from rallygap.models.gap.verdict import Worth
from rallygap.models.gap.verify.verified import Verified
from rallygap.models.gap.verify.worth import Worths
from tests.models.gap.hidden import NOMINAL, SETTINGS, measured

QUESTION = Question(NOMINAL, SETTINGS)
DRAG, DECAY = Hypothesis("drag", "cd"), Hypothesis("spin_decay", "c")
TRUTH = NOMINAL.amended("drag", cd=0.42)


@pytest.fixture(scope="module")
def both():
    """The right cause and one that the shots do not have, verified on other shots."""
    shots = measured(TRUTH, count=30, seed=5)
    fit = refit(shots, NOMINAL, (DRAG, DECAY), SETTINGS.fit)
    evidence = evidence_about(fit, QUESTION)
    places = tuple(k for k, column in enumerate(evidence.columns) if column in (DRAG, DECAY))
    explainer = Explainer(evidence, NOMINAL, places)
    explanation = best_explanation(explainer, places, len(places))
    before, labels = refit(shots, NOMINAL, (), SETTINGS.fit), all_as_read(shots, SETTINGS)
    named = Named(fit, explainer, explanation, True, before, labels)
    return Verified.of(named, measured(TRUTH, count=16, seed=6), QUESTION)


@pytest.fixture(scope="module")
def alone(both):
    """The same without the cause that the shots do not have."""
    return both.without(place(both.named, DECAY))


def place(named, hypothesis):
    return named.explainer.evidence.columns.index(hypothesis)


def test_a_cause_that_the_shots_do_not_have_is_the_weakest(both, alone):
    judgement = both.judgement(fits=True)
    assert judgement.weakest(QUESTION) == place(both.named, DECAY)
    assert judgement.worths.confirmed == {"drag.cd"}
    assert alone.named.fit.free == (DRAG,)
    judgement = alone.judgement(fits=True)
    assert judgement.weakest(QUESTION) is None
    # The worth of the only cause is what amending gains.
    worth = judgement.worths.of_causes["drag.cd"]
    gained = np.mean(alone.gap.before_mm) - np.mean(alone.gap.after_mm)
    assert worth.mm == pytest.approx(gained, abs=0.01)
    assert worth.interval == pytest.approx(alone.gap.reduction_mm, abs=0.01)


def test_a_refit_without_a_cause_gives_the_others_their_own_values(both):
    rest = without_cause(both.named, place(both.named, DRAG), QUESTION)
    direct = refit(both.named.fit.linear.shots, NOMINAL, (DECAY,), SETTINGS.fit)
    assert rest.fit.free == (DECAY,)
    assert DECAY.value(rest.fit.simulator) == pytest.approx(
        DECAY.value(direct.simulator), abs=0.2 * SETTINGS.fit.value_prior * 0.2
    )


@pytest.mark.parametrize(
    ("interval", "fits", "confirmed", "kept", "is_minor"),
    [
        ((1.0, 3.0), True, True, None, False),
        ((-1.0, 3.0), True, True, None, False),  # the likelihood is sure of it
        ((-1.0, 3.0), False, True, None, True),  # where the model does not fit, predictions must be
        ((-1.0, 3.0), False, True, "irreplaceable", False),
        ((-1.0, 3.0), False, False, "irreplaceable", True),  # the likelihood is not sure of it
        ((-3.0, -1.0), False, True, "irreplaceable", True),  # predictions are better without it
        ((-3.0, -1.0), True, True, None, True),
        ((-3.0, -1.0), True, False, "needed", False),
        ((-0.1, 0.01), True, True, None, False),  # negligible next to the other cause, but sure
        ((0.001, 0.01), False, True, None, True),
    ],
)
def test_predictions_decide_where_the_model_does_not_fit(
    alone, interval, fits, confirmed, kept, is_minor
):
    worths = {"drag.cd": Worth(mm=sum(interval) / 2, interval=interval)}
    worths["other"] = Worth(mm=5.0, interval=(4.0, 6.0))
    sure = frozenset(["drag.cd"]) if confirmed else frozenset()
    stays = {kept: frozenset([place(alone.named, DRAG)])} if kept else {}
    judgement = replace(alone.judgement(fits), worths=Worths(worths, sure), **stays)
    assert (judgement.weakest(QUESTION) is not None) == is_minor


def test_held_out_shots_are_likelier_with_the_right_cause(both, alone):
    assert both.is_likelier_than(both.without(place(both.named, DRAG)))
    assert not both.is_likelier_than(alone)
