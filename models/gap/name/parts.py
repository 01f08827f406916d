"""Parts of the gap: what each named cause, and what no cause explains, adds to measurements."""

from collections.abc import Iterator

import numpy as np

from rallygap.models.gap.hypotheses import LABEL_SIGNS
from rallygap.models.gap.locate.attribution import Part
from rallygap.models.gap.name.distortion import CAMERA
from rallygap.models.gap.name.naming import Named
from rallygap.models.gap.name.unexplained import UnexplainedStructure

UNEXPLAINED = ""  # identity of the part that no cause explains


def parts(named: Named, structure: UnexplainedStructure | None) -> list[Part]:
    """Return the parts of the gap, about the shots as they were fitted with the causes."""
    return [*_of_causes(named), *_of_sensor(named), *_of_structure(structure)]


def _of_causes(named: Named) -> Iterator[Part]:
    linear, nominal = named.fit.linear, named.explainer.nominal
    for k in named.explanation.causes:
        hypothesis = named.explainer.evidence.columns[k]
        change = hypothesis.value(named.simulator) - hypothesis.value(nominal)
        column = linear.nuisance_count + linear.columns.index(hypothesis)
        positions, labels = linear.positions[..., column], linear.labels[..., column]
        phase = hypothesis.phase
        yield Part(hypothesis.identity, phase, change * positions, change * labels)


def _of_sensor(named: Named) -> Iterator[Part]:
    """Yield the position-dependent camera error, and labels that are read with wrong signs."""
    linear = named.fit.linear
    no_places, no_labels = np.zeros(linear.positions.shape[:3]), np.zeros(linear.labels.shape[:3])
    if named.distortion is not None:
        errors = linear.positions[..., linear.of_shared] @ named.fit.camera_errors
        yield Part(CAMERA.identity, "sensor", errors, no_labels)
    if named.readings.significant:
        negated = -2.0 * linear.shots.labels / linear.label_scales[..., None]
        flipped = np.isin(np.arange(len(negated)), sorted(named.readings.flipped))
        used = linear.labelled & flipped[:, None]
        labels = np.where(used[..., None], negated, 0.0)
        yield Part(LABEL_SIGNS.identity, "sensor", no_places, labels)


def _of_structure(structure: UnexplainedStructure | None) -> Iterator[Part]:
    if structure is None:
        return
    linear, test = structure.linear, structure.test
    # Less what the catalogue's parameters would do instead: terms may nearly be in their span.
    values = np.zeros(len(linear.columns))
    values[test.places] = structure.terms
    values[test.given] = -structure.terms @ test.projection.mixing
    positions, labels = (
        rows[..., linear.of_hypotheses] @ values for rows in (linear.positions, linear.labels)
    )
    yield Part(UNEXPLAINED, structure.phase, positions, labels)
