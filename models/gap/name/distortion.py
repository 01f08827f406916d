"""Camera distortion: whether cameras err as a smooth function of place, in all shots alike.

The size of the error is a variance component (fit/shared_errors.py). Its likelihood ratio against
none has half a chance of being zero, else a chi-squared distribution (Self and Liang 1987).
"""

from dataclasses import dataclass, replace

from scipy.stats import chi2

from models.gap.fit.camera_field import CameraField
from models.gap.fit.refit import RefitResult
from models.gap.fit.shared_errors import DistortionLikelihood
from models.gap.fit.variance_components import NoiseEstimate
from models.gap.hypotheses import Hypothesis
from models.gap.settings import GapSettings, Question

CAMERA = Hypothesis("camera_distortion", "amplitude")


def find_distortion(fit: RefitResult, question: Question) -> CameraField | None:
    """Return the functions of the cameras' error over space, where shots show such an error.

    The level of this test is not that of causes: an error that is not modelled passes for physics,
    one that is modelled in vain costs time only.
    """
    settings = question.settings
    if CAMERA.effect in question.withheld:
        return None
    field = CameraField.over(fit.linear.shots, settings.fit.camera_field)
    linear = fit.linear.with_shared(field.on(fit.linear.shots, fit.fitted_places))
    known = fit.noise_estimate
    noise = NoiseEstimate.known(linear, known.noise, known.weights, settings.fit)
    with_field = replace(fit, linear=linear, noise_estimate=noise)
    level = settings.fit.camera_field.level
    return field if Distortion.of(with_field, settings).p_value <= level else None


@dataclass(frozen=True)
class Distortion:
    """How large the cameras' error over space is.

    Attributes:
        likelihood: of its standard deviation.
        confidence: of the interval.
    """

    likelihood: DistortionLikelihood
    confidence: float

    @classmethod
    def of(cls, fit: RefitResult, settings: GapSettings) -> "Distortion":
        """Return what shots with shared errors say."""
        bounds = settings.fit.noise_bounds["distortion"]
        likelihood = DistortionLikelihood.of(fit.shared_errors, bounds)
        return cls(likelihood, settings.confidence)

    @property
    def amplitude(self) -> float:
        """The likeliest standard deviation, m."""
        return self.likelihood.estimate

    @property
    def p_value(self) -> float:
        """Of so large a likelihood ratio without any distortion."""
        gain = self.likelihood.gain
        return 0.5 * float(chi2.sf(gain, 1)) if gain > 0.0 else 1.0

    @property
    def interval(self) -> tuple[float, float]:
        """Of the standard deviation, m."""
        return self.likelihood.interval(self.confidence)
