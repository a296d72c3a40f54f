"""Encodings of pictures, compared with the figures in the standards."""

from __future__ import annotations

import numpy as np
import pytest

from vidstyle.core.picture import LUMA_WEIGHTS, SITINGS, Encoding, Picture
from vidstyle.errors import UsageError

PUBLISHED = {
    "bt601": [[1, 0, 1.402], [1, -0.344136, -0.714136], [1, 1.772, 0]],
    "bt709": [[1, 0, 1.5748], [1, -0.187324, -0.468124], [1, 1.8556, 0]],
    "bt2020": [[1, 0, 1.4746], [1, -0.164553, -0.571353], [1, 1.8814, 0]],
}
"""Y'CbCr to R'G'B' as printed in BT.601, BT.709 and BT.2020 (non-constant luminance)."""


@pytest.mark.parametrize("matrix", PUBLISHED)
def test_matrices_are_the_published_ones(matrix: str) -> None:
    encoding = Encoding(matrix)
    np.testing.assert_allclose(encoding.to_rgb, PUBLISHED[matrix], atol=1e-6)


@pytest.mark.parametrize("matrix", LUMA_WEIGHTS)
def test_matrices_keep_white_and_undo_each_other(matrix: str) -> None:
    encoding = Encoding(matrix)
    to_rgb, from_rgb = (each.astype(np.float64) for each in (encoding.to_rgb, encoding.from_rgb))
    np.testing.assert_allclose(to_rgb @ from_rgb, np.eye(3), atol=3e-7)
    np.testing.assert_allclose(from_rgb @ [1, 1, 1], [1, 0, 0], atol=1e-7)
    np.testing.assert_allclose(from_rgb[0], encoding.weights, atol=1e-7)
    np.testing.assert_allclose(from_rgb @ [0, 0, 1], [encoding.weights[2], 0.5, from_rgb[2, 2]], atol=1e-7)
    assert from_rgb[2, 0] == pytest.approx(0.5)
    assert encoding.weights.sum() == pytest.approx(1, abs=1e-7)


@pytest.mark.parametrize(
    ("depth", "full", "luma", "chroma"),
    [
        (8, False, (16, 235), (128, 224)),
        (10, False, (64, 940), (512, 896)),
        (12, False, (256, 3760), (2048, 3584)),
        (16, False, (4096, 60160), (32768, 57344)),
        (8, True, (0, 255), (128, 255)),
        (10, True, (0, 1023), (512, 1023)),
        (16, True, (0, 65535), (32768, 65535)),
        (0, True, (0, 1), (0, 1)),
        (0, False, (0, 1), (0, 1)),
    ],
)
def test_levels(depth: int, full: bool, luma: tuple[int, int], chroma: tuple[int, int]) -> None:
    encoding = Encoding(depth=depth, full_range=full)
    assert (encoding.luma_levels, encoding.chroma_levels) == (luma, chroma)
    assert encoding.dtype == {0: np.float32, 8: np.uint8}.get(depth, np.uint16)


@pytest.mark.parametrize(
    ("step", "shape"),
    [((2, 2), (181, 321)), ((2, 1), (361, 321)), ((1, 2), (181, 641)), ((4, 1), (361, 161))],
)
def test_chroma_planes_are_rounded_up(step: tuple[int, int], shape: tuple[int, int]) -> None:
    assert Encoding(subsampling=step).chroma_shape(361, 641) == shape


def test_sitings_are_those_of_h273() -> None:
    """Chroma_sample_loc_type 0 to 5 in its order (ITU-T H.264, figure E-1)."""
    assert list(SITINGS.values()) == [(0, 0.5), (0.5, 0.5), (0, 0), (0.5, 0), (0, 1), (0.5, 1)]


def test_as_float_keeps_the_colours() -> None:
    encoding = Encoding("bt2020", depth=10, siting=SITINGS["top"])
    assert encoding.as_float() == Encoding("bt2020", True, 0, (1, 1), SITINGS["top"])


def test_a_picture_is_luma_or_color() -> None:
    plane, color = np.zeros((2, 2), np.uint8), np.zeros((2, 2, 3), np.uint8)
    for planes in ({}, {"luma": plane, "color": color}, {"color": color, "chroma": (plane, plane)}):
        with pytest.raises(ValueError, match="picture"):
            Picture(Encoding(), **planes)
    assert Picture(Encoding(), luma=np.zeros((2, 5), np.uint8)).shape == (2, 5)
    assert Picture(Encoding(), color=np.zeros((3, 4, 3), np.uint8)).shape == (3, 4)


@pytest.mark.parametrize(
    ("dtype", "depth"), [(np.uint8, 8), (np.uint16, 16), (np.float32, 0), (np.float64, 0), (np.float16, 0)]
)
@pytest.mark.parametrize("shape", [(2, 3), (2, 3, 3), (2, 3, 4)])
def test_from_array(dtype: type[np.generic], depth: int, shape: tuple[int, ...]) -> None:
    array = np.arange(np.prod(shape)).reshape(shape).astype(dtype) / np.array(1 if depth else 32, dtype)
    array = array.astype(dtype)
    picture = Picture.from_array(array)
    assert picture.encoding == Encoding("bt709", full_range=True, depth=depth, subsampling=(1, 1))
    held = picture.luma if len(shape) == 2 else picture.color
    assert held is not None
    assert held.dtype == picture.encoding.dtype
    assert (picture.alpha is not None) == (shape[-1] == 4)
    np.testing.assert_array_equal(held, array[..., :3] if len(shape) == 3 else array)
    if picture.alpha is not None:
        np.testing.assert_array_equal(picture.alpha, array[..., 3])
    assert np.shares_memory(held, array) == (array.dtype == held.dtype)


@pytest.mark.parametrize(
    "array",
    [np.zeros(3), np.zeros((2, 2, 2)), np.zeros((0, 4)), np.zeros((1, 1, 1, 3)), np.zeros((2, 2), np.int32)],
)
def test_from_array_refuses_what_is_no_picture(array: np.ndarray) -> None:
    with pytest.raises(ValueError, match="picture is an array of"):
        Picture.from_array(array)


def test_masked_pixels_are_refused() -> None:
    whole = np.ma.masked_array(np.zeros((2, 2, 3), np.uint8), mask=False)
    assert type(Picture.from_array(whole).color) is np.ndarray
    whole[0, 0, 0] = np.ma.masked
    with pytest.raises(UsageError, match=r"picture has masked pixels; give picture.filled\(value\)"):
        Picture.from_array(whole)
