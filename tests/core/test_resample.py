"""Resampling: rows and columns alike, bands, and what is given."""

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
