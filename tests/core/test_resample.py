"""Resampling: symmetry of rows and columns, bands, and arguments."""

from __future__ import annotations

import numpy as np
import pytest
from covering import in_one_test

from vidstyle.core.resample import METHODS, Resampling, fitting_method, resample

SIZES = [(1, 1), (1, 9), (9, 1), (5, 40), (33, 47), (64, 200), (200, 31)]


def noise(*shape: int) -> np.ndarray:
    return np.random.default_rng(7).random(shape, np.float32)


@pytest.mark.parametrize("method", METHODS)
@in_one_test("new", [*SIZES, (47, 59), (41, 44), (17, 23)])
def test_columns_are_resampled_as_rows_are(method: str, new: tuple[int, int]) -> None:
    """They are other loops: over neighbours that are permuted, and over whole rows."""
    for old in SIZES:
        colors = noise(*old, 3)
        out = resample(colors, new, method)
        turned = resample(np.ascontiguousarray(colors.transpose(1, 0, 2)), new[::-1], method)
        np.testing.assert_allclose(out, turned.transpose(1, 0, 2), rtol=0, atol=2e-6)
        channel = resample(np.ascontiguousarray(colors[..., 1]), new, method)
        np.testing.assert_array_equal(out[..., 1], channel)


@pytest.mark.parametrize("method", METHODS)
@in_one_test("new", [(64, 90), (21, 31), (33, 90), (64, 47)])
def test_bands_are_those_of_the_whole(method: str, new: tuple[int, int]) -> None:
    plane = noise(33, 47)
    whole = resample(plane, new, method)
    resampling = Resampling(plane.shape, new, fitting_method(method, plane.shape, new))
    for top in range(0, new[0], 4):
        bottom = min(top + 4, new[0])
        first, last = resampling.rows_read(top, bottom)
        rows = resampling.rows(plane[first:last], first, top, bottom)
        np.testing.assert_array_equal(rows, whole[top:bottom])


@in_one_test("new", [(64, 90), (21, 31)])
def test_codes_become_floats(new: tuple[int, int]) -> None:
    codes = (255 * noise(33, 47)).astype(np.uint8)
    for method in set(METHODS) - {"nearest"}:
        out = resample(codes, new, method)
        assert out.dtype == np.float32
        np.testing.assert_array_equal(out, resample(codes.astype(np.float32), new, method))


@pytest.mark.parametrize("method", ["bilinear", "smooth"])
def test_border_repeats_the_border_of_the_old_plane(method: str) -> None:
    """Equal to resampling a plane that is extended first."""
    plane, small = noise(40, 60), noise(26, 36)
    extended = resample(np.pad(plane, 6, mode="edge"), (26, 36), method)
    np.testing.assert_array_equal(resample(plane, (26, 36), method, 3), extended)
    inside = resample(small, (52, 72), method)[6:-6, 6:-6]
    np.testing.assert_array_equal(resample(small, (40, 60), method, -3), inside)


@in_one_test("old", [(33, 47), (1, 1), (200, 31)])
def test_bands_with_a_border_are_those_of_the_whole(old: tuple[int, int]) -> None:
    new, plane = (17, 31), noise(*old)
    whole, resampling = resample(plane, new, "smooth", 3), Resampling(old, new, "smooth", 3)
    for top in range(0, new[0], 2):
        bottom = min(top + 2, new[0])
        first, last = resampling.rows_read(top, bottom)
        rows = resampling.rows(plane[first:last], first, top, bottom)
        np.testing.assert_array_equal(rows, whole[top:bottom])
