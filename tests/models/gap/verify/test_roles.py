"""Roles: worth is a difference of prediction errors, and what is not needed is minor."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from rallygap.models.gap.diagnose import _reduced
from rallygap.models.gap.fit.refit import refit
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.name.label_readings import all_as_read
from rallygap.models.gap.name.naming import Named, without_cause
from rallygap.models.gap.name.selection import Explainer, best_explanation, evidence_about
from rallygap.models.gap.settings import Question
from rallygap.models.gap.verdict import Worth
from rallygap.models.gap.verify.roles import Judgement
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
    ("interval", "fits", "is_minor"),
    [
        ((1.0, 3.0), True, False),
        ((-1.0, 3.0), True, False),  # the likelihood is sure of it
        ((-1.0, 3.0), False, True),  # where the model does not fit, predictions must be
        ((-3.0, -1.0), True, True),  # predictions are better without it
        ((-0.1, 0.01), True, False),  # negligible next to the other cause, but sure
        ((0.001, 0.01), False, True),
    ],
)
def test_predictions_decide_where_the_model_does_not_fit(alone, interval, fits, is_minor):
    judgement = alone.judgement(fits)
    worths = {"drag.cd": Worth(mm=sum(interval) / 2, interval=interval)}
    worths["other"] = Worth(mm=5.0, interval=(4.0, 6.0))
    changed = replace(judgement, worths=replace(judgement.worths, of_causes=worths))
    assert (changed.weakest(QUESTION) is not None) == is_minor
    assert isinstance(changed, Judgement)


@pytest.mark.parametrize(
    ("interval", "confirmed", "is_minor"),
    [
        ((-1.0, 3.0), True, False),
        ((-1.0, 3.0), False, True),  # the likelihood is not sure of it
        ((-3.0, -1.0), True, True),  # predictions are better without it
    ],
)
def test_a_cause_that_only_a_larger_error_of_the_cameras_could_replace_stays(
    alone, interval, confirmed, is_minor
):
    drag = frozenset([place(alone.named, DRAG)])
    worths = {"drag.cd": Worth(mm=1.0, interval=interval)}
    sure = frozenset(["drag.cd"]) if confirmed else frozenset()
    judgement = replace(alone.judgement(False, drag), worths=Worths(worths, sure))
    assert (judgement.weakest(QUESTION) is not None) == is_minor


def test_held_out_shots_are_likelier_with_the_right_cause_and_it_stays(both, alone):
    drag = place(both.named, DRAG)
    assert both.is_likelier_than(both.without(drag))
    assert not both.is_likelier_than(alone)
    worths = Worths({"drag.cd": Worth(mm=-2.0, interval=(-3.0, -1.0))}, frozenset())
    judgement = replace(alone.judgement(fits=True), worths=worths)
    assert judgement.weakest(QUESTION) == drag
    assert replace(judgement, needed=frozenset([drag])).weakest(QUESTION) is None


class Replaced:
    """Two needless causes; an error of the cameras grows to 20 mm in place of the first."""

    question, named = QUESTION, None

    def __init__(self, high, causes=(0, 1)):
        self.causes = causes
        self.camera_size = (0.001 if 0 in causes else 0.02, high)

    def without(self, k):
        return Replaced(self.camera_size[1], tuple(j for j in self.causes if j != k))

    def is_likelier_than(self, other):
        return False

    def judgement(self, fits, irreplaceable=frozenset()):
        return Needless(self.causes, irreplaceable, frozenset())


@dataclass(frozen=True)
class Needless:
    """A judgement by which all causes are needless."""

    causes: tuple[int, ...]
    irreplaceable: frozenset[int]
    needed: frozenset[int]
    worths = Worths({}, frozenset())

    def weakest(self, question):
        stay = self.irreplaceable | self.needed
        return next((k for k in self.causes if k not in stay), None)

    def identity(self, k):
        return str(k)


def test_an_error_of_the_cameras_does_not_take_the_place_of_a_cause(monkeypatch):
    monkeypatch.setattr("rallygap.models.gap.diagnose.cause", lambda named, k, *of: k)
    main, _, minor = _reduced(Replaced(high=0.003), True, {})
    assert (main.causes, minor) == ((0,), [1])
    main, _, minor = _reduced(Replaced(high=0.03), True, {})  # it may be so large in any case
    assert (main.causes, minor) == ((), [0, 1])


@pytest.mark.parametrize(("fits", "kept"), [(True, (0, 1)), (False, ())])
def test_needed_causes_stay_where_the_model_fits(monkeypatch, fits, kept):
    monkeypatch.setattr("rallygap.models.gap.diagnose.cause", lambda named, k, *of: k)
    monkeypatch.setattr(Replaced, "is_likelier_than", lambda self, other: True)
    main, _, _ = _reduced(Replaced(high=0.03), fits, {})
    assert main.causes == kept
