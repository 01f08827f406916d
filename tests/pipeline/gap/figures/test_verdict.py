"""The figures of a verdict show the numbers they were given."""

import numpy as np

from rallygap.pipeline.gap.figures.verdict import causes_figure, error_figure
from tests.pipeline.verdicts import GAP, GRAVITY, MINOR, WIND, verdict


def departures(found):
    """The (interval, estimate) drawn for every cause."""
    lines = [line.get_xdata().tolist() for line in causes_figure(found).figure.axes[0].lines[1:]]
    return list(zip(lines[::2], [x for (x,) in lines[1::2]], strict=True))


def test_causes_are_drawn_in_minimum_detectable_effects_of_the_verdict():
    found = verdict("ambiguous", (WIND, GRAVITY))
    axes = causes_figure(found).figure.axes[0]
    assert [label.get_text() for label in axes.get_yticklabels()] == ["wind.x", "gravity.g"]
    for (interval, estimate), cause in zip(departures(found), (WIND, GRAVITY), strict=True):
        size = found.minimum_detectable[cause.identity]
        ends = np.array([*cause.interval, cause.estimate])
        expected = (ends - cause.nominal) / size
        np.testing.assert_allclose([*interval, estimate], expected)


def test_a_cause_without_a_minimum_detectable_effect_has_its_estimate_as_text():
    found = verdict(minimum_detectable={})
    assert departures(found) == []
    (text,) = causes_figure(found).figure.axes[0].texts
    assert text.get_text().startswith("0.61 m/s, simulator 0; no minimum detectable effect")


def test_minor_structure_is_not_drawn():
    assert len(departures(verdict(causes=(WIND, MINOR)))) == 1


def test_errors_are_drawn_over_the_horizon():
    axes = error_figure(GAP).figure.axes[0]
    for line, values in zip(axes.lines, (GAP.before_mm, GAP.after_mm, GAP.floor_mm), strict=True):
        np.testing.assert_array_equal(line.get_xydata(), np.column_stack([GAP.horizons_ms, values]))
    within = (GAP.before_interval_mm, GAP.after_interval_mm)
    for band, intervals in zip(axes.collections, within, strict=True):
        (low, high) = np.array(intervals)[-1]
        ends = {y for x, y in band.get_paths()[0].vertices if x == GAP.horizons_ms[-1]}
        assert ends == {low, high}
