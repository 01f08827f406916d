"""Camera distortion: whether cameras err as a smooth function of place, in all shots alike.

A smooth error of position bends paths as wind, a tilted frame or a high table do. So it competes
with all causes: the most likely explanation with an error of the cameras, of its most likely size,
is compared with the most likely explanation without one, both less a penalty for each cause
(selection.py).
It competes as well with an effect of the flight that differs between the sides of the net.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rallygap.models.gap.fit.camera_field import CameraField
from rallygap.models.gap.fit.refit import RefitResult
from rallygap.models.gap.fit.shared_errors import SharedErrors, VarianceLikelihood, variance_p_value
from rallygap.models.gap.fit.variance_components import NoiseEstimate
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.name.by_side import side_tests
from rallygap.models.gap.name.selection import Explainer
from rallygap.models.gap.settings import FitSettings
from rallygap.models.gap.types import Places

CAMERA = Hypothesis("camera_distortion", "amplitude")
AT_BOUND = 1e-3  # relative distance from the bound, against rounding of the search


@dataclass(frozen=True)
class Distortion:
    """A position-dependent camera error.

    Attributes:
        field: its functions, of its maximum-likelihood standard deviation.
        gain: of twice the penalised log likelihood, over the best explanation without it.
        causes: places of the most likely causes together with it.
    """

    field: CameraField
    gain: float
    causes: Places

    @property
    def p_value(self) -> float:
        """Of so large a gain without any error of the cameras."""
        return variance_p_value(self.gain)

    def is_plausible(self, fit: RefitResult) -> bool:
        """Return whether its size, by a refit, is not at its bound."""
        high = self.field.settings.sizes[1]
        return self.field.size * self.size(fit).estimate < (1 - AT_BOUND) * high

    def size(self, fit: RefitResult) -> VarianceLikelihood:
        """Return the likelihood of the standard deviation in that of the field, by a refit."""
        places = [fit.linear.columns.index(cause) for cause in fit.free]
        low, high = np.array(self.field.settings.sizes) / self.field.size
        return VarianceLikelihood.of(fit.shared_errors.about(places), (low, high))


def with_field(fit: RefitResult, field: CameraField, settings: FitSettings) -> RefitResult:
    """Return a fit with the functions of a field as shared errors, at the fitted places."""
    linear, known = fit.linear, fit.noise_estimate
    linear = linear.with_shared(field.on(linear.shots, fit.fitted_places))
    noise = NoiseEstimate.known(linear, known.noise, known.weights, settings)
    return replace(fit, linear=linear, noise_estimate=noise)


def find_distortion(fit: RefitResult, explainer: Explainer) -> Distortion | None:
    """Return the position-dependent camera error, where shots with the causes in them show one.

    All is linear about the fit: the causes that an error of the cameras may take the place of are
    small, while one that is far off stays in.
    """
    settings = explainer.evidence.settings
    unit = CameraField.over(fit.linear.shots, settings.fit.camera_field, 1.0)
    rivals = _Rivals.of(with_field(fit, unit, settings.fit), explainer)
    low, high = settings.fit.camera_field.sizes
    sizes = np.geomspace(low, high, settings.fit.camera_field.tried_sizes).tolist()
    scored = {size: rivals.score(size) for size in sizes}
    best = max(sizes, key=lambda size: scored[size][0])
    score, causes = scored[best]
    found = Distortion(replace(unit, size=best), score - rivals.score(0.0)[0], causes)
    plausible = best < high  # as with any cause, a size at its bound is none
    if not plausible or found.p_value > settings.level:
        return None
    return found if found.gain > _gain_by_side(fit, explainer) else None


def _gain_by_side(fit: RefitResult, explainer: Explainer) -> float:
    """Return the most that a difference of a parameter between sides gains, less its penalty."""
    evidence = explainer.evidence
    given = [evidence.columns[k] for k in sorted({*evidence.free, *explainer.refitted})]
    tests = side_tests(fit, given, evidence.settings)
    return max((test.gain for test in tests.values()), default=0.0) - explainer.penalty


@dataclass(frozen=True, eq=False)
class _Rivals:
    """Explanations with an error of the cameras and without.

    Attributes:
        shared: what the shots say of departures of the hypotheses from the nominal simulator, and
            of functions of unit size.
        explainer: that has named the causes, without such an error.
    """

    shared: SharedErrors
    explainer: Explainer

    @classmethod
    def of(cls, fit: RefitResult, explainer: Explainer) -> "_Rivals":
        columns, evidence = fit.linear.columns, explainer.evidence
        departures = fit.linear.departures(explainer.nominal)
        places = [columns.index(column) for column in evidence.columns]
        return cls(fit.shared_errors.from_departures(departures).about(places), explainer)

    def score(self, size: float) -> tuple[float, Places]:
        """Return the score of the best explanation with an error of this size, and its causes."""
        known = self.explainer
        with_errors = replace(self.shared, precision=size**-2.0) if size else None
        totals = with_errors.marginal if with_errors else self.shared.alone
        sets = known.set_scores.with_total(*totals)
        most = len(known.refitted) + 2
        causes = sets.best((), list(known.candidates), most, known.penalty, known.handicaps)
        taken = known.penalty * len(causes) + known.handicaps[list(causes)].sum()
        return sets.gain(causes) - taken - self._alone.deviance(size), causes

    @cached_property
    def _alone(self) -> VarianceLikelihood:
        """Of an error of the cameras alone, the simulator being the nominal one."""
        return VarianceLikelihood.of(self.shared.about([]), (0.0, 1.0))
