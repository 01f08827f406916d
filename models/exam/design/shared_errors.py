"""Errors that all shots of a trial share, as random effects of detection limits.

A distortion is a Gaussian field and the labels' error of a session a Gaussian vector, both of their
true size. In a basis of independent components of unit variance they are linear, so they are
columns next to the hypotheses, with a prior. Integrating them out leaves the information on the
hypotheses that these errors do not hide.
"""

from dataclasses import replace

import numpy as np

from rallygap.models.ball.camera_field import covariance
from rallygap.models.ball.types import Bools, Floats
from rallygap.models.exam.simulate.camera_errors import Distortion
from rallygap.models.exam.simulate.trial import Trial
from rallygap.models.gap.fit.linearize import Linearised

PLACES = 400  # that represent the recorded region
LEFT_OUT = 1e-3  # of the field's variance


def with_shared_columns(linear: Linearised, trial: Trial) -> Linearised:
    """Return linearised shots with columns of shared errors, before the residual."""
    if trial.errors.distortion is not None:
        linear = _with_field(linear, trial.errors.distortion)
    if trial.errors.labels.session:
        linear = _with_session(linear, trial.errors.labels.session)
    return linear


def _with_field(linear: Linearised, distortion: Distortion) -> Linearised:
    basis = _field_basis(linear.shots.positions, linear.sampled, distortion)
    return linear.with_shared(replace(linear.shots, shared=basis))


def _with_session(linear: Linearised, size: float) -> Linearised:
    of_labels = np.zeros((*linear.labels.shape[:3], 3))
    of_labels[linear.labelled] = size * np.eye(3)
    return _appended(linear, np.zeros((*linear.positions.shape[:3], 3)), of_labels)


def _field_basis(positions: Floats, sampled: Bools, distortion: Distortion) -> Floats:
    """Return (B, N, J) components of a field of one coordinate, zero where nothing is sampled.

    They are the leading ones of the Karhunen-Loeve expansion over recorded places (Nystroem).
    """
    places = positions[sampled]
    chosen = places[np.linspace(0, len(places) - 1, PLACES).astype(np.int64)]
    values, vectors = np.linalg.eigh(covariance(chosen, chosen, distortion.length))
    tail = np.cumsum(np.maximum(values, 0.0))
    used = tail > LEFT_OUT * tail[-1]
    basis = np.zeros((*sampled.shape, int(used.sum())))
    across = covariance(places, chosen, distortion.length)
    basis[sampled] = distortion.size * across @ (vectors[:, used] / np.sqrt(values[used]))
    return basis


def _appended(linear: Linearised, of_positions: Floats, of_labels: Floats) -> Linearised:
    def joined(columns: Floats, more: Floats) -> Floats:
        return np.concatenate([columns[..., :-1], more, columns[..., -1:]], axis=-1)

    return replace(
        linear,
        positions=joined(linear.positions, of_positions),
        labels=joined(linear.labels, of_labels),
    )
