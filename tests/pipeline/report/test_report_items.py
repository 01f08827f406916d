"""Figures and animations in their files."""

import numpy as np
from matplotlib.figure import Figure
from PIL import Image, ImageSequence

from rallygap.pipeline.web.report_items import ReportAnimation, ReportFigure

FRAMES = np.random.default_rng(0).integers(256, size=(4, 30, 40, 3), dtype=np.uint8)


def test_an_animation_has_every_pixel_and_rests_on_its_last_frame(tmp_path):
    item = ReportAnimation(FRAMES, "noise", title="Noise", caption="In motion.")
    item.write(tmp_path / item.file)
    with Image.open(tmp_path / "figures" / "noise.png") as animation:
        frames = ImageSequence.Iterator(animation)
        seen = [(np.asarray(frame), frame.info["duration"]) for frame in frames]
        assert animation.info["loop"] == 0  # without end
    np.testing.assert_array_equal([pixels for pixels, _ in seen], FRAMES)
    assert [duration for _, duration in seen] == [40, 40, 40, 1000]
