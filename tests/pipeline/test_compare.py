"""Source and result in one picture (`--compare`)."""

from __future__ import annotations

import numpy as np
import pytest
from covering import in_one_test

from vidstyle.core.picture import Encoding, Picture
from vidstyle.pipeline.compare import compare_pictures


def flat(luma: int, chroma: int, width: int, step: tuple[int, int] = (2, 2), height: int = 6) -> Picture:
    encoding = Encoding(subsampling=step)
    plane = np.full(encoding.chroma_shape(height, width), chroma, np.uint8)
    return Picture(encoding, luma=np.full((height, width), luma, np.uint8), chroma=(plane, plane.copy()))


@in_one_test("width", [1, 2, 7, 640, 641])
@in_one_test("step", [(1, 1), (2, 1), (2, 2), (4, 1)])
def test_side_keeps_all_of_both_pictures(width, step):
    both = compare_pictures(flat(20, 100, width, step), flat(200, 150, width, step), "side")
    left = both.shape[1] - width
    assert left >= width
    assert both.luma.shape == (6, left + width)
    assert np.all(both.luma[:, :left] == 20) and np.all(both.luma[:, left:] == 200)
    for plane in both.chroma:
        assert plane.shape == both.encoding.chroma_shape(*both.shape)
        assert np.all(plane[:, : left // step[0]] == 100) and np.all(plane[:, left // step[0] :] == 150)


@pytest.mark.parametrize("width", [8, 641, 1920])
@pytest.mark.parametrize("step", [(1, 1), (2, 1), (2, 2)])
def test_split_has_a_thin_white_line_between_the_halves(width, step):
    both = compare_pictures(flat(20, 100, width, step), flat(200, 150, width, step), "split")
    row = both.luma[0].tolist()
    assert len(row) == width
    line = row.count(235)
    assert 1 <= line <= max(2, width // 300)
    middle = row.index(235)
    assert abs(middle - width / 2) <= 2
    assert row == [20] * middle + [235] * line + [200] * (width - middle - line)
    neutral = both.chroma[0][0].tolist()
    assert neutral == [100] * (middle // step[0]) + [128] * (line // step[0]) + [150] * neutral.count(150)
    assert both.chroma[0].shape == both.encoding.chroma_shape(*both.shape)


def test_rgb_and_alpha_are_compared_too():
    before = Picture.from_array(np.zeros((4, 10, 4), np.uint16))
    after = Picture.from_array(np.full((4, 10, 4), 40000, np.uint16))
    both = compare_pictures(before, after, "split")
    assert both.color[0, :, 1].tolist() == [0] * 5 + [65535] + [40000] * 4
    assert both.alpha[0].tolist() == [0] * 5 + [65535] + [40000] * 4
