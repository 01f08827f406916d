"""The map of the cameras' error shows the error that the verdict has."""

import numpy as np
import pytest

from rallygap.pipeline.gap.figures.camera import HEIGHTS, camera_figure, position_errors
from rallygap.pipeline.web.figure_style import apply_style
from tests.pipeline.verdicts import CAMERA, CAMERA_NODES, WIND, verdict

FOUND = verdict(causes=(WIND, CAMERA), camera=CAMERA_NODES)
# Balls over one half of the table, none of them high.
PLACES = np.random.default_rng(0).uniform([-0.7, -1.3, 0.0], [0.7, 0.0, 0.4], (4000, 3))


def test_errors_are_those_of_the_nodes():
    place = np.array([0.1, -0.5, 0.3])
    nodes = np.array(CAMERA_NODES.nodes)
    near = np.exp(-((place - nodes[:, :3]) ** 2).sum(axis=1) / (2 * 0.8**2))
    expected = 0.003 * near @ nodes[:, 3:]
    assert position_errors(FOUND, place[None])[0] == pytest.approx(expected, abs=1e-12)


@pytest.fixture(autouse=True)
def style():
    apply_style()


def test_slices_show_errors_in_mm_where_balls_were():
    *panels, bar = camera_figure(FOUND, PLACES).figure.axes
    assert bar.get_ylabel() == "error in z (mm)"
    for axes, height in zip(panels, HEIGHTS, strict=True):
        assert axes.get_title(loc="left") == f"z = {height:g} m"
        mesh, arrows = axes.collections
        drawn = np.ma.masked_invalid(mesh.get_array())
        corners = np.stack([arrows.X, arrows.Y, np.full_like(arrows.X, height)], axis=-1)
        seen = ~np.broadcast_to(arrows.Umask, arrows.U.shape)
        assert seen.any() == (height < 0.5)
        expected = 1e3 * position_errors(FOUND, corners[seen])[:, :2]
        shown = np.column_stack([arrows.U[seen], arrows.V[seen]])
        np.testing.assert_allclose(shown, expected, atol=1e-9)
        assert (drawn.count() > 0) == (height < 0.5)


def test_without_an_error_of_the_cameras_places_are_right():
    assert not position_errors(verdict(), np.ones((2, 3))).any()
