"""Orientation and resizing: pixels, sizes, chroma steps and sitings are transformed together."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from covering import in_one_test

from vidstyle.core.picture import Encoding, Picture
from vidstyle.errors import UsageError
from vidstyle.media.orientation import Orientation
from vidstyle.media.resize import letterbox_picture, output_size, resize_picture

ALL = [Orientation(*flags) for flags in itertools.product((False, True), repeat=3)]


def ramp(height: int, width: int, step: tuple[int, int], siting: tuple[float, float]) -> Picture:
    """Luma 2 x + y, and chroma of the same light where its samples lie."""
    encoding = Encoding(depth=16, subsampling=step, siting=siting)
    y, x = np.mgrid[:height, :width]
    rows, columns = encoding.chroma_shape(height, width)
    below, across = np.mgrid[:rows, :columns]
    chroma = 200 * (siting[0] + step[0] * across) + 100 * (siting[1] + step[1] * below) + 5000
    luma = (200 * x + 100 * y + 5000).astype(np.uint16)
    return Picture(encoding, luma=luma, chroma=(chroma.astype(np.uint16),) * 2)


def misfit(picture: Picture) -> float:
    """How far chroma is from luma's light at the places that the encoding names, inside the picture."""
    height, width = picture.shape
    (across, down), (x, y) = picture.encoding.subsampling, picture.encoding.siting
    plane = picture.chroma[0]
    rows, columns = y + down * np.arange(plane.shape[0]), x + across * np.arange(plane.shape[1])
    rows_in = (rows >= 3) & (rows <= height - 4)
    columns_in = (columns >= 3) & (columns <= width - 4)
    luma = picture.luma.astype(float)
    at_columns = np.array([np.interp(columns[columns_in], np.arange(width), row) for row in luma])
    expected = np.array([np.interp(rows[rows_in], np.arange(height), column) for column in at_columns.T]).T
    return float(np.abs(plane[rows_in][:, columns_in] - expected).max())


@in_one_test("orientation", ALL)
@in_one_test("size", [(24, 32), (23, 31)])
@in_one_test("step, siting", [((2, 2), (0.0, 0.5)), ((2, 1), (0.0, 0.0)), ((4, 1), (0.0, 0.0))])
def test_chroma_stays_on_its_luma_however_it_is_turned(orientation, size, step, siting):
    picture = ramp(*size, step, siting)
    turned = orientation.apply(picture)
    assert turned.shape == orientation.size(*size)
    assert turned.chroma[0].shape == turned.encoding.chroma_shape(*turned.shape)
    assert misfit(turned) <= 1


def test_a_phones_left_sited_film_is_top_sited_once_upright():
    upright = Orientation.from_rotation(90).apply(ramp(24, 32, (2, 2), (0.0, 0.5)))
    assert upright.encoding.siting == (0.5, 0.0) and upright.encoding.subsampling == (2, 2)


@pytest.mark.parametrize("turns", range(4))
def test_turns_are_clockwise(turns):
    plane = np.arange(12, dtype=np.uint8).reshape(3, 4)
    assert (Orientation.from_rotation(90 * turns).plane(plane) == np.rot90(plane, -turns)).all()


@pytest.mark.parametrize("orientation", ALL)
def test_a_display_matrix_says_where_columns_and_rows_go(orientation):
    across = -65536 if orientation.mirror_x else 65536
    down = -65536 if orientation.mirror_y else 65536
    a, b, c, d = (0, down, across, 0) if orientation.transpose else (across, 0, 0, down)
    assert Orientation.from_matrix([a, b, 0, c, d, 0, 0, 0, 1 << 30]) == orientation


def test_a_display_matrix_without_a_direction_turns_nothing():
    """Of zeros, as in damaged files, and at 45 degrees."""
    assert Orientation.from_matrix([0] * 9).is_upright
    assert Orientation.from_matrix([1, 1, 0, -1, 1, 0, 0, 0, 1]).is_upright


@pytest.mark.parametrize("size", [(48, 36), (16, 12), (33, 25), (64, 24)])
@pytest.mark.parametrize("siting", [(0.0, 0.5), (0.5, 0.5), (0.0, 0.0)])
def test_chroma_stays_on_its_luma_at_another_size(size, siting):
    picture = ramp(24, 32, (2, 2), siting)
    fitted = resize_picture(picture, *size)
    assert fitted.shape == size[::-1] and fitted.encoding == picture.encoding
    assert misfit(fitted) < 60, "a quarter of a luma pixel of the source"


def test_bars_are_black_and_the_picture_in_between_is_whole():
    picture = ramp(40, 20, (2, 2), (0.0, 0.5))
    boxed = letterbox_picture(picture, 80, 40)
    assert boxed.shape == (40, 80)
    assert (boxed.luma[:, :30] == 16 * 256).all() and (boxed.luma[:, 50:] == 16 * 256).all()
    assert (boxed.chroma[0][:, :15] == 128 * 256).all()
    assert (boxed.luma[:, 30:50] == picture.luma).all()


def test_bars_of_rgb_with_alpha():
    color = np.full((10, 10, 3), 200, np.uint8)
    picture = Picture(Encoding("bt709", True, 8, (1, 1)), color=color, alpha=np.full((10, 10), 7, np.uint8))
    boxed = letterbox_picture(picture, 30, 10)
    assert boxed.color[5, 0].tolist() == [0, 0, 0] and boxed.alpha[5, 0] == 255 and boxed.alpha[5, 15] == 7


@pytest.mark.parametrize("wanted", [(0, 10), (-1, -1), (-3, 10), (10, -5)])
def test_sizes_that_are_none(wanted):
    with pytest.raises(UsageError):
        output_size(wanted, 100, 100)


def test_a_narrow_picture_never_vanishes():
    assert output_size((4, -1), 8192, 16) == (4, 1) and output_size((4, -2), 8192, 16) == (4, 2)
