"""What a stage reports, read for the page."""

import base64
import io

import numpy as np
import pytest
from PIL import Image

from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.web.pages import read_columns, read_figure, read_first_frame
from rallygap.pipeline.web.report_items import ReportAnimation
from tests.pipeline.report.example_reports import moving_dot


def cells(path, text):
    path.write_text(text)
    return {column.name: column.cells for column in read_columns(path)}


def test_numbers_have_four_digits_of_their_columns_largest_and_text_is_shown_as_it_is(tmp_path):
    shown = cells(tmp_path / "a.csv", "large,small\n12345.678,0.00012345\n0.5,0.00001\n")
    assert shown == {"large": ["12346", "0"], "small": ["0.0001234", "0.0000100"]}
    shown = cells(tmp_path / "a.csv", "n,name,flag\n123456,NA,True\n,tt3d/003,False\n")
    assert shown == {"n": ["123456", "–"], "name": ["NA", "tt3d/003"], "flag": ["True", "False"]}
    vanishing = cells(tmp_path / "a.csv", "p\n12.5\n0.00003\n0\n-0.004\n")
    assert vanishing == {"p": ["12.50", "3e-05", "0.00", "-0.004"]}


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "is not a CSV table"),
        ("x,y\n1,2,3\n", "is not a CSV table"),
        ("x,y\n0.5,1e999\n", "y has a number that is not"),
    ],
)
def test_tables_that_no_stage_writes_are_refused(tmp_path, text, problem):
    with pytest.raises(InputError, match=problem):
        cells(tmp_path / "a.csv", text)


def test_first_frame_of_an_animation_stands_still(tmp_path):
    ReportAnimation(moving_dot(), "ball", title="", caption="").write(tmp_path / "ball.png")
    shown = read_first_frame(tmp_path / "ball.png")
    still = Image.open(io.BytesIO(base64.b64decode(shown.partition("base64,")[2])))
    assert not still.is_animated
    np.testing.assert_array_equal(np.asarray(still), moving_dot()[0])


@pytest.mark.parametrize(
    ("reader", "content"), [(read_figure, b"<svg/>"), (read_first_frame, b"\x89PNG\r\n\x1a\n")]
)
def test_a_picture_that_is_no_png_is_refused(tmp_path, reader, content):
    (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(InputError, match="is not a PNG"):
        reader(tmp_path / "a.png")
