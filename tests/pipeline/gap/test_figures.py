"""The figures of a verdict show the numbers they were given."""

import numpy as np
import pytest
from matplotlib.colors import to_hex

from rallygap.pipeline.gap import figures
from tests.pipeline.verdicts import CAMERA, CAMERA_NODES, GRAVITY, LOCATED, MINOR, WIND, verdict

CAMERAS = verdict(causes=(WIND, CAMERA), camera=CAMERA_NODES)
# Balls over one half of the table, none of them high.
PLACES = np.random.default_rng(0).uniform([-0.7, -1.3, 0.0], [0.7, 0.0, 0.4], (4000, 3))


def test_causes_are_drawn_in_minimum_detectable_effects_of_the_verdict():
    found = verdict("ambiguous", (WIND, GRAVITY, MINOR))
    axes = figures.causes_figure(found).figure.axes[0]
    assert [label.get_text() for label in axes.get_yticklabels()] == ["wind.x", "gravity.g"]
    drawn = [line.get_xdata() for line in axes.lines[1:]]
    for cause, interval, estimate in zip((WIND, GRAVITY), drawn[::2], drawn[1::2], strict=True):
        ends = np.array([*cause.interval, cause.estimate])
        expected = (ends - cause.nominal) / found.minimum_detectable[cause.identity]
        np.testing.assert_allclose([*interval, *estimate], expected)


def test_slices_show_the_errors_of_the_nodes_in_mm_where_balls_were():
    nodes = np.array(CAMERA_NODES.nodes)
    *panels, _ = figures.camera_figure(CAMERAS, PLACES).figure.axes
    for axes, height in zip(panels, figures.HEIGHTS, strict=True):
        mesh, arrows = axes.collections
        drawn = np.ma.masked_invalid(mesh.get_array())
        corners = np.stack([arrows.X, arrows.Y, np.full_like(arrows.X, height)], axis=-1)
        seen = ~np.broadcast_to(arrows.Umask, arrows.U.shape)
        assert seen.any() == (drawn.count() > 0) == (height < 0.5)
        apart = corners[seen][:, None] - nodes[:, :3]
        expected = 3.0 * np.exp(-(apart**2).sum(axis=-1) / (2 * 0.8**2)) @ nodes[:, 3:5]
        shown = np.column_stack([arrows.U[seen], arrows.V[seen]])
        np.testing.assert_allclose(shown, expected, atol=1e-9)


def test_the_discrepancy_is_drawn_by_phase_and_by_direction():
    phases, directions = figures.discrepancy_figure(LOCATED).figure.axes
    tops = {
        to_hex(band.get_facecolor()[0]): band.get_paths()[0].vertices[:, 1].max()
        for band in phases.collections
    }
    assert [tops[colour] for colour in figures.PHASE_COLOURS.values()] == pytest.approx([6, 9, 12])
    np.testing.assert_allclose(phases.lines[0].get_ydata(), [0, 2, 6, 12])
    np.testing.assert_allclose(directions.lines[3].get_xydata(), [[100, 0], [200, 3], [300, 6]])
