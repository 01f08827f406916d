"""Camera distortion: whether cameras err as a smooth function of place, in all shots alike.

The size of the error is a variance component (fit/shared_errors.py). Its likelihood ratio against
none has half a chance of being zero, else a chi-squared distribution (Self and Liang 1987).
"""

from scipy.stats import chi2

from models.gap.fit.camera_field import CameraField
from models.gap.fit.refit import RefitResult
from models.gap.fit.shared_errors import DistortionLikelihood
from models.gap.fit.variance_components import NoiseEstimate, shared_errors
from models.gap.settings import Question

DISTORTION = "camera_distortion"  # the effect


def find_distortion(fit: RefitResult, question: Question) -> CameraField | None:
    """Return the functions of the cameras' error over space, where shots show such an error.

    The level of this test is not that of causes: an error that is not modelled passes for physics,
    one that is modelled in vain costs time only.
    """
    settings = question.settings
    if DISTORTION in question.withheld:
        return None
    field = CameraField.over(fit.linear.shots, settings.fit.camera_field)
    linear = fit.linear.with_shared(field.on(fit.linear.shots, fit.fitted_places))
    known = fit.noise_estimate
    noise = NoiseEstimate.known(linear, known.noise, known.weights, settings.fit)
    shared = shared_errors(linear, noise.gram_matrices, noise.noise)
    likelihood = DistortionLikelihood.of(shared, settings.fit.noise_bounds["distortion"])
    return field if p_value(likelihood) <= settings.fit.camera_field.level else None


def p_value(likelihood: DistortionLikelihood) -> float:
    """Return the probability of so large a likelihood ratio without any distortion."""
    return 0.5 * float(chi2.sf(likelihood.gain, 1)) if likelihood.gain > 0.0 else 1.0
