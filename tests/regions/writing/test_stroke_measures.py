"""Kernels that measure strokes and weigh writing, compared with plain definitions in NumPy."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view
from pictures import noise, picture_with_writing

from vidstyle.core.kernels import compiled
from vidstyle.regions.writing import cell_means, cell_weights
from vidstyle.regions.writing.cell_means import average_measures
from vidstyle.regions.writing.cell_weights import weigh_cells
from vidstyle.regions.writing.morphology import average_floats
from vidstyle.regions.writing.stroke_measures import EVEN_LEVEL, EVEN_LEVEL_RATIO, measure_strokes

SHAPES = [(96, 128), (4, 4), (8, 44), (52, 12)]


def textured(shape: tuple[int, int]) -> np.ndarray:
    """Return luma with strokes of many widths and contrasts, uint8."""
    grain = cv2.GaussianBlur(noise(*shape, seed=5), (0, 0), 1.2)
    return np.asarray(cv2.normalize(grain, None, 0, 255, cv2.NORM_MINMAX), np.uint8)


def over_squares(
    plane: np.ndarray, size: int, function: Callable[..., np.ndarray], **padding: object
) -> np.ndarray:
    padded = np.pad(plane, size // 2, **padding)
    return function(sliding_window_view(padded, (size, size)), axis=(2, 3))


def dilated(plane: np.ndarray, size: int) -> np.ndarray:
    return over_squares(plane, size, np.max, constant_values=0)


def eroded(plane: np.ndarray, size: int) -> np.ndarray:
    return over_squares(plane, size, np.min, constant_values=255)


def averaged(plane: np.ndarray, size: int) -> np.ndarray:
    return over_squares(np.asarray(plane, np.float64), size, np.mean, mode="reflect")


def halved(plane: np.ndarray) -> np.ndarray:
    total = sum(plane[y::2, x::2].astype(int) for y in (0, 1) for x in (0, 1))
    return np.asarray((total + 2) // 4, np.uint8)


def slope_products(plane: np.ndarray) -> list[np.ndarray]:
    around = sliding_window_view(np.pad(plane.astype(int), 1, mode="reflect"), (3, 3))
    smooth, slope = np.array([1, 2, 1]), np.array([-1, 0, 1])
    across = np.einsum("yxij,i,j->yx", around, smooth, slope)
    down = np.einsum("yxij,i,j->yx", around, slope, smooth)
    return [np.rint(each / 256) for each in (across * across, down * down, across * down)]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("thickness", [3, 5])
def test_measures_are_those_of_dilations_and_erosions(shape: tuple[int, int], thickness: int) -> None:
    luma = textured(shape)
    levels, products = measure_strokes(luma, thickness)
    for side, plane in enumerate((luma, 255 - luma)):
        closed = eroded(dilated(plane, thickness), thickness)
        wide = eroded(dilated(plane, 2 * thickness + 1), 2 * thickness + 1)
        strokes = closed - plane
        peaks = np.rint(averaged(dilated(strokes, thickness), thickness)).astype(np.uint8)
        limit = np.rint(np.float32(EVEN_LEVEL_RATIO) * peaks + np.float32(EVEN_LEVEL))
        bright, island = (closed - dilated(eroded(closed, size), size) for size in (thickness, 5 * thickness))
        even = np.uint8(255) * (wide - plane < limit)
        wanted = [halved(each) for each in (strokes, bright, even, peaks, island)]
        assert np.array_equal(levels[side], wanted)
        assert np.array_equal(products[side], slope_products(wanted[0]))


@pytest.mark.parametrize("shape", [(5, 7), (31, 90), (43, 6), (9, 641)])
def test_odd_sizes_keep_their_borders(shape: tuple[int, int]) -> None:
    """A square at the border is the mean of its pixels, as in OpenCV."""
    luma = textured(shape)
    levels, _ = measure_strokes(luma, 3)
    square = np.ones((3, 3), np.uint8)
    strokes = cv2.subtract(cv2.morphologyEx(luma, cv2.MORPH_CLOSE, square), luma)
    wanted = cv2.resize(strokes, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    assert np.array_equal(levels[0, 0], wanted)


@compiled
def average(plane, size, scratch, out):  # type: ignore[no-untyped-def]
    average_floats(plane, size, scratch, out)


@pytest.mark.parametrize("shape", [(20, 30), (1, 1), (2, 40), (9, 3)])
@pytest.mark.parametrize("size", [3, 5, 11, 17])
def test_moving_sums_are_means(shape: tuple[int, int], size: int) -> None:
    plane = noise(*shape, seed=size)
    out, (height, width) = np.empty_like(plane), shape
    average(plane, size, (np.empty((height + 1, width)), np.empty(width + size)), out)
    assert np.array_equal(out, cv2.blur(plane, (size, size)))


def test_cells_of_any_size_have_the_same_means() -> None:
    """By the kernel for cells of 2 x 2 pixels, by OpenCV for others: nearly equal for nearly equal cells."""
    measures = measure_strokes(textured((96, 128)), 3)
    sums = np.empty((25, 32)), np.empty(40)
    quarter, nearby, _ = average_measures(measures, (24, 32), 3, sums)
    exact = measures.levels.reshape(2, 5, 24, 2, 32, 2).mean(axis=(3, 5))
    assert np.abs(quarter[:, :5] - exact).max() <= 0.5
    sums = np.empty((24, 31)), np.empty(40)
    other, _, _ = average_measures(measures, (23, 31), 3, sums)
    assert np.abs(quarter.mean(axis=(2, 3)) - other.mean(axis=(2, 3))).max() < 1
    for mean, around in zip(quarter.reshape(-1, 24, 32), nearby.reshape(-1, 24, 32), strict=True):
        assert np.allclose(around, averaged(mean, 3), rtol=1e-5, atol=1e-3)


def ramp(values: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    share = np.clip((values - ends[0]) / (ends[1] - ends[0]), 0, 1)
    return share * share * (3 - 2 * share)


def plain_weights(luma: np.ndarray, means: np.ndarray, thickness: int) -> np.ndarray:
    """Return the weights of cells by float64, from means of measures in cells."""

    def near(plane: np.ndarray, ratio: float) -> np.ndarray:
        return averaged(plane, max(1, 2 * round((ratio * thickness / 4 - 1) / 2) + 1))

    sides, grounds = [], []
    for own in means.astype(np.float64):
        ink, rest, even, tops, islands, squares, others, mixed = (near(each, 4) for each in own)
        coherence = np.hypot(squares - others, 2 * mixed) / (squares + others + 1e-3)
        weight = ramp(own[3], cell_weights.STRENGTH_RANGE) * ramp(even / 255, cell_weights.GROUND_RANGE)
        weight *= ramp(rest / (ink + 0.25), cell_weights.BRIGHT_RANGE)
        weight *= ramp(coherence, cell_weights.COHERENCE_RANGE)
        agreement = near(own[0] * weight, 9) / (near(own[0], 9) + 0.25)
        weight *= ramp(agreement, cell_weights.AGREEMENT_RANGE)
        reach = max(1, 2 * round((3 * thickness / 4 - 1) / 2) + 1)
        weight = averaged(dilated(weight, 2 * reach - 1), reach)
        sides.append(ramp(weight, cell_weights.WEIGHT_RANGE))
        grounds.append(np.maximum(1 - islands / (tops + 1), cell_weights.MIN_GROUND_WEIGHT))
    side = near(sides[0] * grounds[0] - sides[1] * grounds[1], 13) / cell_weights.SIDE_DIFFERENCE
    weights = np.maximum(*sides) * np.stack([ramp(side, (0, 1)), ramp(-side, (0, 1))])
    samples = luma[::4, ::4]
    bare = samples[weights.max(axis=0) == 0]
    (low, high), (lowest, highest) = (
        np.percentile(each, [0.5, 99.5]) for each in (bare if bare.size else samples, samples)
    )
    contrast = (high - low + 1) / (highest - lowest + 1) if bare.size else 0
    return weights * ramp(np.array(contrast), cell_weights.REST_CONTRAST_RANGE)


@pytest.mark.parametrize("dark", [True, False])
@pytest.mark.parametrize("rows", [slice(0, 360), slice(80, 232)])
def test_weights_follow_their_definition(dark: bool, rows: slice) -> None:
    """Also where little is left beyond the writing."""
    luma = np.ascontiguousarray(picture_with_writing(dark)[rows, :, 1])
    thickness = 5 if luma.shape[0] > 320 else 3
    measures = measure_strokes(luma, thickness)
    shape = luma.shape[0] // cell_means.CELL_PX, luma.shape[1] // cell_means.CELL_PX
    sums = np.empty((shape[0] + 1, shape[1])), np.empty(shape[1] + 30)
    means, _, _ = average_measures(measures, shape, 3, sums)
    found = weigh_cells(luma, measures, thickness)
    assert np.abs(found - plain_weights(luma, means, thickness)).max() < 1e-3
    assert (found.max() > 0.5) == (rows.start == 0)
