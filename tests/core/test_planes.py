"""Conversion between planes and working values, compared with closed forms, and chroma siting."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from covering import in_one_test
from pictures import codes

from vidstyle.core.codes import IDENTITY_MIX_WEIGHTS, chroma_radius, store, store_chroma, store_yuv
from vidstyle.core.color.deferred_color import Mixed, Printed
from vidstyle.core.picture import SITINGS, Encoding, Picture
from vidstyle.core.planes import (
    chroma_rows,
    color_rows,
    luma_rows,
    rgb_from_yuv,
    yuv_from_rgb,
)

WEIGHTS = {
    "bt601": (0.299, 0.587, 0.114),
    "bt709": (0.2126, 0.7152, 0.0722),
    "bt2020": (0.2627, 0.678, 0.0593),
}
ENCODINGS = [
    Encoding(matrix, full, depth, (1, 1))
    for matrix, full, depth in product(WEIGHTS, (False, True), (8, 10, 16))
]
SUBSAMPLED = [
    *[((2, 2), siting) for siting in SITINGS.values()],
    # "left" and "topleft" after rotations by 90, 180 and 270 degrees.
    *[((2, 2), siting) for siting in [(1.0, 0.5), (1.0, 0.0), (1.0, 1.0), (0.5, 1.0), (0.0, 1.0)]],
    *[((2, 1), (x, 0.0)) for x in (0.0, 0.5, 1.0)],
    *[((1, 2), (0.0, y)) for y in (0.0, 0.5, 1.0)],
    *[((4, 1), (x, 0.0)) for x in (0.0, 1.5, 3.0)],
    *[((1, 4), (0.0, y)) for y in (0.0, 1.5, 3.0)],
    *[((4, 4), siting) for siting in [(0.0, 1.5), (1.5, 1.5), (3.0, 0.0)]],
]

every_encoding = in_one_test("encoding", ENCODINGS)
every_subsampling = in_one_test("step, siting", SUBSAMPLED)


def averaged(plane: np.ndarray, above: int, rows: int, encoding: Encoding) -> np.ndarray:
    """The chroma samples of a band, as floats."""
    encoding = replace(encoding, depth=0)
    blue, red = np.empty((2, *encoding.chroma_shape(rows, plane.shape[1])), np.float32)
    store_chroma((plane, -plane), IDENTITY_MIX_WEIGHTS, above, encoding, (blue, red))
    np.testing.assert_array_equal(red, -blue)
    return blue


def expected_rgb(luma: np.ndarray, blue: np.ndarray, red: np.ndarray, encoding: Encoding) -> np.ndarray:
    """RGB of integer codes by the formulas of H.273, section 8.3, in float64."""
    unit, top = 2 ** (encoding.depth - 8), 2**encoding.depth - 1
    luma, blue, red = (plane.astype(np.float64) for plane in (luma, blue, red))
    if encoding.full_range:
        luma, blue, red = luma / top, (blue - (top + 1) // 2) / top, (red - (top + 1) // 2) / top
    else:
        luma = (luma / unit - 16) / 219
        blue, red = (blue / unit - 128) / 224, (red / unit - 128) / 224
    of_red, of_green, of_blue = WEIGHTS[encoding.matrix]
    r, b = luma + 2 * (1 - of_red) * red, luma + 2 * (1 - of_blue) * blue
    return np.stack([r, (luma - of_red * r - of_blue * b) / of_green, b], axis=2)


@every_encoding
def test_planes_to_rgb(encoding: Encoding) -> None:
    picture = codes(encoding, 9, 13)
    assert picture.luma is not None and picture.chroma is not None
    rgb = expected_rgb(picture.luma, *picture.chroma, encoding)
    np.testing.assert_allclose(color_rows(picture, 0, 9), rgb, atol=1e-6)
    np.testing.assert_allclose(color_rows(picture, 4, 7), rgb[4:7], atol=1e-6)
    np.testing.assert_allclose(luma_rows(picture, 0, 9), rgb @ WEIGHTS[encoding.matrix], atol=1e-6)


@every_encoding
def test_planes_to_rgb_and_back_are_the_same_codes(encoding: Encoding) -> None:
    picture = codes(encoding, 40, 50)
    assert picture.luma is not None and picture.chroma is not None
    luma, *chroma = yuv_from_rgb(color_rows(picture, 0, 40), encoding)
    neutral, span = encoding.chroma_levels
    levels = [encoding.luma_levels, (neutral, neutral + span), (neutral, neutral + span)]
    for values, (black, white), plane in zip(
        (luma, *chroma), levels, (picture.luma, *picture.chroma), strict=True
    ):
        out = np.empty_like(plane)
        store(values, black, white, encoding.depth, out)
        np.testing.assert_array_equal(out, plane)


@pytest.mark.parametrize(
    ("encoding", "color", "code"),
    [
        (Encoding("bt601"), (1, 0, 0), (81, 90, 240)),
        (Encoding("bt601"), (0, 1, 0), (145, 54, 34)),
        (Encoding("bt601"), (0, 0, 1), (41, 240, 110)),
        (Encoding("bt709"), (1, 0, 0), (63, 102, 240)),
        (Encoding("bt709"), (0, 1, 0), (173, 42, 26)),
        (Encoding("bt709"), (0, 0, 1), (32, 240, 118)),
        (Encoding("bt709"), (1, 1, 1), (235, 128, 128)),
        (Encoding("bt601", full_range=True), (1, 0, 0), (76, 85, 255)),
        (Encoding("bt2020", depth=10), (1, 0, 0), (294, 387, 960)),
    ],
)
def test_colour_bars(encoding: Encoding, color: tuple[int, ...], code: tuple[int, ...]) -> None:
    """The codes of pure colours, as colour bar tables print them."""
    values = yuv_from_rgb(np.full((1, 1, 3), color, np.float32), encoding)
    neutral, span = encoding.chroma_levels
    stored = []
    for plane, levels in zip(values, [encoding.luma_levels, *[(neutral, neutral + span)] * 2], strict=True):
        out = np.empty((1, 1), encoding.dtype)
        store(plane, *levels, encoding.depth, out)
        stored.append(int(out[0, 0]))
    assert tuple(stored) == code


def test_rgb_from_yuv_undoes_yuv_from_rgb_outside_the_cube_too() -> None:
    color = np.random.default_rng(2).uniform(-1, 2, (7, 9, 3)).astype(np.float32)
    luma, *chroma = yuv_from_rgb(color, Encoding())
    np.testing.assert_allclose(rgb_from_yuv(luma, (chroma[0], chroma[1]), Encoding()), color, atol=2e-6)


def test_luma_of_mixed_channels_is_that_of_the_clipped_mix() -> None:
    random = np.random.default_rng(3)
    color, matrix = random.random((5, 19, 3), np.float32), random.uniform(-1, 1.5, (3, 4)).astype(np.float32)
    mixed = Mixed(color, matrix)
    expected = np.clip(np.einsum("ij,yxj->yxi", matrix[:, :3].astype(float), color) + matrix[:, 3], 0, 1)
    np.testing.assert_allclose(mixed.whole(), expected, atol=1e-6)
    luma = mixed.luma(Encoding().weights)
    np.testing.assert_allclose(luma, expected @ WEIGHTS["bt709"], atol=1e-6)


def ramp(shape: tuple[int, int], step: tuple[int, int], siting: tuple[float, float]) -> np.ndarray:
    """A tilted plane, taken where the samples of the step and siting lie; all values are exact in float32."""
    x = np.arange(shape[1]) * step[0] + (siting[0] if step[0] > 1 else 0)
    y = np.arange(shape[0])[:, None] * step[1] + (siting[1] if step[1] > 1 else 0)
    return ((2 * x - 3 * y) / 1024).astype(np.float32)


@every_subsampling
@in_one_test("size", [(24, 32), (23, 31), (25, 33)])
def test_a_ramp_survives_both_ways(
    step: tuple[int, int], siting: tuple[float, float], size: tuple[int, int]
) -> None:
    encoding = Encoding(depth=0, full_range=True, subsampling=step, siting=siting)
    small = ramp(encoding.chroma_shape(*size), step, siting)
    large = ramp(size, (1, 1), (0, 0))
    inside = (slice(4, -4), slice(4, -4))
    blue, red = chroma_rows(
        Picture(encoding, luma=np.zeros(size, np.float32), chroma=(small, -small)), 0, size[0]
    )
    np.testing.assert_array_equal(blue[inside], large[inside])
    np.testing.assert_array_equal(red, -blue)
    back = averaged(large, 0, size[0], encoding)
    assert back.shape == small.shape
    down, across = (-(-8 // each) for each in reversed(step))
    inside = (slice(down, -down), slice(across, -across))
    np.testing.assert_allclose(back[inside], small[inside], rtol=0, atol=1e-7)


@every_subsampling
def test_bands_of_chroma_are_those_of_the_whole(step: tuple[int, int], siting: tuple[float, float]) -> None:
    encoding = Encoding(subsampling=step, siting=siting)
    picture = codes(encoding, 29, 31)
    whole = chroma_rows(picture, 0, 29)
    shrunk = averaged(whole[0], 0, 29, encoding)
    above, below = chroma_radius(encoding)
    for top, bottom in ((0, 8), (8, 20), (20, 29)):
        band = chroma_rows(picture, top, bottom)
        np.testing.assert_array_equal(np.stack(band), np.stack(whole)[:, top:bottom])
        first, last = max(top - above, 0), min(bottom + below, 29)
        rows = averaged(whole[0][first:last], top - first, bottom - top, encoding)
        np.testing.assert_array_equal(rows, shrunk[top // step[1] : -(-bottom // step[1])])


@every_subsampling
def test_rgb_is_stored_as_its_luma_and_its_chroma(step: tuple[int, int], siting: tuple[float, float]) -> None:
    """In one go, in bands, as the planes one after another."""
    encoding = Encoding(subsampling=step, siting=siting)
    color = np.random.default_rng(6).uniform(-0.1, 1.1, (29, 31, 3)).astype(np.float32)
    wanted, *planes = yuv_from_rgb(color, encoding)
    luma, in_bands = np.zeros((2, 29, 31), np.uint8)
    store(wanted, *encoding.luma_levels, 8, luma)
    chroma, chroma_in_bands = np.zeros((2, 2, *encoding.chroma_shape(29, 31)), np.uint8)
    store_chroma((planes[0], planes[1]), IDENTITY_MIX_WEIGHTS, 0, encoding, (chroma[0], chroma[1]))
    above, below = chroma_radius(encoding)
    for top, bottom in ((0, 8), (8, 20), (20, 29)):
        first, last = max(top - above, 0), min(bottom + below, 29)
        blue, red = chroma_in_bands[:, top // step[1] : -(-bottom // step[1])]
        store_yuv(color[first:last], top - first, encoding, in_bands[top:bottom], (blue, red))
    np.testing.assert_array_equal(in_bands, luma)
    np.testing.assert_array_equal(chroma_in_bands, chroma)


@every_subsampling
@pytest.mark.parametrize("paper", [None, (0.9, 0.8, 0.7)], ids=["inked", "on paper"])
def test_printed_rgb_is_stored_as_what_it_becomes(step: Any, siting: Any, paper: Any) -> None:
    """Paper and ink are laid on row by row."""
    encoding, rng = Encoding(subsampling=step, siting=siting), np.random.default_rng(8)
    color, lines = (rng.uniform(-0.1, 1.1, shape).astype(np.float32) for shape in ((9, 11, 3), (9, 11)))
    printed = Printed(color, paper).inked((0.1, 0.2, 0.3), lines)
    under = color if paper is None else np.clip(color * np.array(paper), 0, 1)
    wanted = lines[..., None] * under + (1 - lines[..., None]) * np.array((0.1, 0.2, 0.3))
    np.testing.assert_allclose(printed.whole(), wanted, atol=1e-6)
    stored = []
    for rgb in (printed, printed.whole()):
        luma, (blue, red) = (
            np.zeros((9, 11), np.uint8),
            np.zeros((2, *encoding.chroma_shape(9, 11)), np.uint8),
        )
        store_yuv(rgb, 0, encoding, luma, (blue, red))
        stored.append((luma, blue, red))
    for one, other in zip(*stored, strict=True):
        np.testing.assert_array_equal(one, other)


@every_subsampling
def test_chroma_that_is_a_sum_of_planes(step: tuple[int, int], siting: tuple[float, float]) -> None:
    encoding = Encoding(depth=16, subsampling=step, siting=siting)
    planes = np.random.default_rng(7).uniform(0, 1, (3, 9, 11)).astype(np.float32)
    mix = np.array([[0.2, -0.1], [0, 0.1], [-0.3, 0], [0.05, -0.02]], np.float32)
    summed = np.tensordot(mix[:3], planes, (0, 0)) + mix[3, :, None, None]
    stored, wanted = np.empty((2, 2, *encoding.chroma_shape(9, 11)), np.uint16)
    store_chroma(tuple(planes), mix, 0, encoding, (stored[0], stored[1]))
    store_chroma((summed[0], summed[1]), IDENTITY_MIX_WEIGHTS, 0, encoding, (wanted[0], wanted[1]))
    np.testing.assert_allclose(stored.astype(float), wanted, atol=1)


@every_subsampling
@in_one_test("size", [(1, 1), (1, 7), (3, 2), (5, 5)])
def test_flat_chroma_stays_flat_to_the_edges(
    step: tuple[int, int], siting: tuple[float, float], size: tuple[int, int]
) -> None:
    encoding = Encoding(depth=10, subsampling=step, siting=siting)
    shape = encoding.chroma_shape(*size)
    plane = np.full(shape, 600, np.uint16)
    picture = Picture(encoding, luma=np.zeros(size, np.uint16), chroma=(plane, plane))
    blue, _ = chroma_rows(picture, 0, size[0])
    assert blue.shape == size
    np.testing.assert_allclose(blue, (600 - 512) / 896, atol=1e-6)
    np.testing.assert_allclose(averaged(blue, 0, size[0], encoding), (600 - 512) / 896, atol=1e-6)


def test_smooth_subsampled_planes_come_back_through_rgb() -> None:
    """4:2:0 with soft colours: luma exact, chroma where it is linear."""
    encoding = Encoding()
    chroma = np.rint(128 + 512 * ramp((12, 16), (2, 2), encoding.siting)).astype(np.uint8)
    luma = codes(replace(encoding, subsampling=(1, 1)), 24, 32).luma
    picture = Picture(encoding, luma=luma, chroma=(chroma, chroma))
    back, blue, _ = yuv_from_rgb(color_rows(picture, 0, 24), encoding)
    out = np.empty((24, 32), np.uint8)
    store(back, 16, 235, 8, out)
    np.testing.assert_array_equal(out, luma)
    small = np.empty((12, 16), np.uint8)
    store(averaged(blue, 0, 24, encoding), 128, 352, 8, small)
    np.testing.assert_array_equal(small[1:-1, 1:-1], chroma[1:-1, 1:-1])


def test_gray_has_neutral_chroma_and_equal_channels() -> None:
    picture = Picture(Encoding(), luma=np.arange(16, 236, dtype=np.uint8).reshape(11, 20))
    assert not np.any(chroma_rows(picture, 0, 11))
    color = color_rows(picture, 0, 11)
    np.testing.assert_array_equal(color, np.repeat(luma_rows(picture, 0, 11)[..., None], 3, axis=2))


def test_rgb_planes_are_scaled_by_their_own_range() -> None:
    color = np.array([[[0, 128, 255], [16, 235, 100]]], np.uint8)
    full, limited = (
        Picture(Encoding(full_range=each, subsampling=(1, 1)), color=color) for each in (True, False)
    )
    np.testing.assert_allclose(color_rows(full, 0, 1), color / 255, atol=1e-7)
    np.testing.assert_allclose(color_rows(limited, 0, 1), (color - 16.0) / 219, atol=1e-6)
    np.testing.assert_allclose(luma_rows(full, 0, 1), color / 255 @ WEIGHTS["bt709"], atol=1e-6)


@pytest.mark.parametrize(("depth", "top"), [(8, 255), (10, 1023), (16, 65535)])
def test_store_rounds_and_cuts_off_at_the_numbers_ends(depth: int, top: int) -> None:
    values = np.array([[-1, -0.4 / top, 0.5 / top, 1.49 / top, 1, 1 + 0.4 / top, 2]], np.float32)
    out = np.empty(values.shape, Encoding(depth=depth).dtype)
    store(values, 0, top, depth, out)
    assert out.tolist() == [[0, 0, 1, 1, top, top, top]]


def test_store_keeps_floats_as_they_are() -> None:
    values = np.array([[-0.5, 0.25, 1.5]], np.float32)
    out = np.empty_like(values)
    store(values, 0, 1, 0, out)
    assert out.tolist() == values.tolist()


def test_limited_range_keeps_what_lies_beyond_black_and_white() -> None:
    picture = Picture(Encoding(), luma=np.arange(1, 255, dtype=np.uint8)[None])
    out = np.empty((1, 254), np.uint8)
    store(luma_rows(picture, 0, 1), 16, 235, 8, out)
    np.testing.assert_array_equal(out, picture.luma)


def test_chroma_of_planes_with_different_layouts_is_stored() -> None:
    encoding = Encoding()
    blue, red = np.random.default_rng(3).uniform(-0.5, 0.5, (2, 12, 16)).astype(np.float32)
    wide = np.repeat(red, 2, axis=1)[:, ::2]
    assert not wide.flags.c_contiguous
    same, apart = np.zeros((2, 2, *encoding.chroma_shape(12, 16)), np.uint8)
    store_chroma((blue, red), IDENTITY_MIX_WEIGHTS, 0, encoding, (same[0], same[1]))
    store_chroma((blue, wide), IDENTITY_MIX_WEIGHTS, 0, encoding, (apart[0], apart[1]))
    np.testing.assert_array_equal(apart, same)
