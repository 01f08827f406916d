"""What the shots can show: minimum detectable effects, and parameters that are not identifiable."""

from models.gap.hypotheses import LABEL_SIGNS
from models.gap.inference.score_test import Evidence
from models.gap.name.label_signs import LabelSigns
from models.gap.name.naming import Named, Question
from models.gap.name.selection import evidence_about
from models.gap.verdict import DetectionLimits


def limits_of(named: Named, question: Question) -> DetectionLimits:
    """Return the detection limits of the shots about the nominal simulator."""
    nominal = evidence_about(named.before, question.simulator, question.settings, question.withheld)
    return detection_limits(nominal, named.signs, question)


def detection_limits(evidence: Evidence, labels: LabelSigns, question: Question) -> DetectionLimits:
    """Return the detection limits, each with the simulator's own parameters free.

    Args:
        evidence: of the shots about the nominal simulator.
        labels: how many shots have spin labels.
        question: which effects are not in question.
    """
    free = evidence.free
    sizes = {
        evidence.columns[k].identity: evidence.minimum_detectable_effect(k, free)
        for k in evidence.decidable(free)
    }
    if labels.labelled and LABEL_SIGNS.effect not in question.withheld:
        sizes[LABEL_SIGNS.identity] = labels.detectable
    others = (one.identity for one in evidence.columns if one.identity not in sizes)
    return DetectionLimits(sizes, tuple(others))
