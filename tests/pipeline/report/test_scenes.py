"""The drawn arm is the arm."""

import numpy as np
import pytest

from rallygap.models.robot.constants import BLADE, FOREARM, JOINTS, LOWER, UPPER, UPPER_ARM
from rallygap.models.robot.kinematics import racket
from rallygap.pipeline.report.scenes import arm_lines

POSES = np.random.default_rng(0).uniform(LOWER, UPPER, size=(20, len(JOINTS)))


def test_the_racket_is_where_the_kinematics_have_it_and_links_keep_their_lengths():
    points, normals = arm_lines(POSES)
    expected = racket(POSES, np.zeros_like(POSES))
    assert points[:, -1] == pytest.approx(expected.position, abs=1e-12)
    assert normals == pytest.approx(expected.normal, abs=1e-12)
    lengths = np.linalg.norm(np.diff(points, axis=1), axis=2)
    links = [UPPER_ARM, FOREARM, np.linalg.norm(BLADE)]
    assert lengths == pytest.approx(np.tile(links, (len(POSES), 1)))
