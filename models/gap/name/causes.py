"""From named causes to the parts of a verdict: estimates, classes and detection limits."""

from typing import Any

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.hypotheses import LABEL_SIGNS, Hypothesis
from rallygap.models.gap.inference.score_test import Evidence
from rallygap.models.gap.name.distortion import CAMERA, Distortion
from rallygap.models.gap.name.intervals import within
from rallygap.models.gap.name.label_readings import LabelReadings
from rallygap.models.gap.name.naming import Named
from rallygap.models.gap.settings import Question
from rallygap.models.gap.verdict import CameraNodes, Cause, DetectionLimits, Role, Worth


def detection_limits(
    evidence: Evidence, labels: LabelReadings, question: Question
) -> DetectionLimits:
    """Return the detection limits, by evidence about the nominal simulator, listed ones free."""
    free = evidence.free
    sizes = {
        evidence.columns[k].identity: evidence.minimum_detectable_effect(k, free)
        for k in evidence.decidable(free)
    }
    if labels.labelled and LABEL_SIGNS.effect not in question.withheld:
        sizes[LABEL_SIGNS.identity] = labels.detectable
    identities = (column.identity for column in evidence.columns)
    return DetectionLimits(sizes, tuple(one for one in identities if one not in sizes))


def cause(
    named: Named,
    k: int,
    role: Role,
    gap_shares: dict[str, float],
    worth: Worth | None,
    whole: Named | None = None,
) -> Cause:
    """Return one of the causes as a verdict has it.

    Its interval has that of ``whole`` as well, an explanation with minor causes, if it is given:
    whether those are there is uncertain, and the value may depend on it.
    """
    explainer, places = named.explainer, named.explanation.causes
    hypothesis = explainer.evidence.columns[k]
    estimate, interval = estimated(named, k)
    if whole is not None:
        _, (low, high) = estimated(whole, k)
        interval = min(interval[0], low), max(interval[1], high)
    return Cause(
        **described(hypothesis, explainer.nominal),
        role=role,
        estimate=estimate,
        interval=interval,
        p_value=named.explanation.p_values[k],
        gap_share=gap_shares.get(hypothesis.identity, 0.0),
        worth=worth,
        possible=tuple(
            explainer.evidence.columns[j].identity for j in explainer.alternatives(k, places)
        ),
    )


def estimated(named: Named, k: int) -> tuple[float, tuple[float, float]]:
    """Return the estimate of one of the causes within its bounds, and its interval."""
    evidence, places = named.explainer.evidence, named.explanation.causes
    hypothesis = evidence.columns[k]
    test = evidence.score_test([k], [j for j in places if j != k])
    value = hypothesis.value(named.explainer.nominal) + float(test.estimate[0])
    bounds = hypothesis.declaration.bounds
    return within(value, float(test.margin[0]), bounds, evidence.settings)


def default_role(hypothesis: Hypothesis) -> Role:
    """Return the role of a cause that is no minor structure."""
    return "sensor" if hypothesis.phase == "sensor" else "leading"


def label_signs_cause(named: Named, gap_shares: dict[str, float]) -> Cause:
    """Return the flipped labels as a cause."""
    return Cause(
        **described(LABEL_SIGNS, named.explainer.nominal),
        role="sensor",
        estimate=named.readings.share,
        interval=named.readings.interval,
        p_value=0.0,
        gap_share=gap_shares.get(LABEL_SIGNS.identity, 0.0),
        possible=(LABEL_SIGNS.identity,),
    )


def camera_cause(
    named: Named, found: Distortion, gap_shares: dict[str, float], worth: Worth | None
) -> Cause:
    """Return the position-dependent camera error as a cause."""
    estimate, interval = camera_size(named, found)
    return Cause(
        **described(CAMERA, named.explainer.nominal),
        role="sensor",
        estimate=estimate,
        interval=interval,
        p_value=found.p_value,
        gap_share=gap_shares.get(CAMERA.identity, 0.0),
        worth=worth,
        possible=(CAMERA.identity,),
    )


def camera_nodes(named: Named) -> CameraNodes | None:
    """Return the maximum-likelihood position-dependent camera error, if it is one of the causes."""
    if named.distortion is None:
        return None
    field, size = named.distortion.field, camera_size(named, named.distortion)[0]
    weights = field.node_weights(named.fit.camera_errors) / size
    rows = np.hstack([field.nodes, weights]).round(6)
    return CameraNodes(length=field.settings.length, nodes=tuple(map(tuple, rows.tolist())))


def camera_size(named: Named, found: Distortion) -> tuple[float, tuple[float, float]]:
    """Return the standard deviation of the position-dependent camera error, m, and its interval."""
    size, unit = found.size(named.fit), found.field.size
    low, high = size.interval(named.readings.settings.confidence)
    return unit * size.estimate, (unit * low, unit * high)


def described(hypothesis: Hypothesis, nominal: Simulator) -> dict[str, Any]:
    """Return what a cause has in common with any other about this parameter."""
    return {
        "identity": hypothesis.identity,
        "kind": "wrong_value" if hypothesis.listed(nominal) else "missing_effect",
        "unit": hypothesis.declaration.unit,
        "nominal": hypothesis.value(nominal),
    }
