"""Compare the shipped banks with references that share no code with the program.

`python -m tools.independent_references` prints a table for textured photographs of scikit-image. The
references are written from the equations of the paper and of its sources, with NumPy and SciPy only; their
derivatives, interpolation and truncation are common ones, which differ from `vidstyle.blade.references`.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
import skimage.data
from scipy.ndimage import convolve1d, correlate, gaussian_filter, map_coordinates, shift

from tools import fidelity
from vidstyle.blade.references import tv_flow
from vidstyle.blade.training import psnr

PHOTOGRAPHS = ("brick", "camera", "chelsea", "grass", "gravel", "hubble_deep_field")
"""Photographs with fine texture."""
SIDE_PX = 288
"""Side of the center crop that is filtered."""
BORDER_PX = 16
"""Width of the border that is excluded from the comparison."""
SHARPENING_FACTOR = fidelity.SHARPENING_FACTOR

Picture = np.ndarray


def smooth_tensor(luma: Picture, rho: float, presmoothing: float = 0.0) -> np.ndarray:
    """Return the smoothed structure tensor, 3 x H x W: xx, xy, yy of Scharr's derivatives."""
    smooth = gaussian_filter(luma, presmoothing) if presmoothing else luma
    across, down = (
        convolve1d(
            convolve1d(smooth, [0.5, 0, -0.5], axis, mode="nearest"), [3, 10, 3], 1 - axis, mode="nearest"
        )
        / 16
        for axis in (1, 0)
    )
    return np.stack([gaussian_filter(each, rho) for each in (across * across, across * down, down * down)])


def tangent_at(tensor: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return the eigenvector of the smaller eigenvalue at places between pixels, 2 x H x W (row, column)."""
    xx, xy, yy = (map_coordinates(each, place, order=1, mode="nearest") for each in tensor)
    angle = np.arctan2(2 * xy, xx - yy) / 2 + np.pi / 2
    return np.stack([np.sin(angle), np.cos(angle)])


def integrate_along_lines(plane: Picture, tensor: np.ndarray, sigma: float) -> Picture:
    """Return the line integral convolution with a Gaussian: Runge-Kutta steps of one pixel, second order."""
    start = np.indices(plane.shape).astype(float)
    first = tangent_at(tensor, start)
    total, weights = plane.copy(), 1.0
    for side in (1, -1):
        place, heading = start, side * first
        for step in range(1, int(np.ceil(3 * sigma)) + 1):
            here = align(tangent_at(tensor, place), heading)
            heading = align(tangent_at(tensor, place + here / 2), here)
            place = place + heading
            weight = np.exp(-(step**2) / (2 * sigma**2))
            total += weight * map_coordinates(plane, place, order=1, mode="nearest")
            weights += weight
    return total / weights


def align(tangent: np.ndarray, heading: np.ndarray) -> np.ndarray:
    """Return the tangent, reversed where it points against the heading."""
    return np.where((tangent * heading).sum(axis=0) < 0, -tangent, tangent)


def edge_tangent_flow(luma: Picture, sigma: float, rho: float, passes: int) -> Picture:
    """Section 5.4.2: average along the tangents, which each pass computes again."""
    for _ in range(passes):
        luma = integrate_along_lines(luma, smooth_tensor(luma, rho), sigma)
    return luma


def curvature_flow(luma: Picture, time: float) -> Picture:
    """Section 5.4.1, equation 11, expanded: the second derivative along level lines."""
    now, count = 255 * luma, round(time / 0.2)
    for _ in range(count):
        x, y = (
            correlate(now, kernel, mode="nearest")
            for kernel in (FIRST_DERIVATIVE_MATRIX, FIRST_DERIVATIVE_MATRIX.T)
        )
        xx, yy = (
            correlate(now, kernel, mode="nearest")
            for kernel in (SECOND_DERIVATIVE_MATRIX, SECOND_DERIVATIVE_MATRIX.T)
        )
        xy = correlate(now, MIXED_DERIVATIVE_MATRIX, mode="nearest")
        now = now + time / count * (xx * y * y - 2 * x * y * xy + yy * x * x) / (x * x + y * y + 0.1)
    return now / 255


FIRST_DERIVATIVE_MATRIX = np.array([[0, 0, 0], [-0.5, 0, 0.5], [0, 0, 0]])
SECOND_DERIVATIVE_MATRIX = np.array([[0, 0, 0], [1, -2, 1], [0, 0, 0]])
MIXED_DERIVATIVE_MATRIX = np.array([[1, 0, -1], [0, 0, 0], [-1, 0, 1]]) / 4


def circle_median_flow(luma: Picture, time: float) -> Picture:
    """Return the same flow by medians over circles of 2 px (Oberman 2004), which creates no extremes."""
    now, count, radius = luma, round(time / 0.25), 2.0
    turns = np.arange(32) * 2 * np.pi / 32
    for _ in range(count):
        circle = [
            shift(now, radius * np.array([np.sin(t), np.cos(t)]), order=3, mode="nearest") for t in turns
        ]
        now = now + time / count * 2 / radius**2 * (np.median(circle, axis=0) - now)
    return now


def flow_dog(luma: Picture, sigma: float) -> Picture:
    """Section 5.4.3: (1 + p) G - p G' across the edge, of sigma and 1.6 sigma, then along the flow."""
    coarse = max(sigma, 1.0)
    tensor = smooth_tensor(luma, 2 * coarse, 0.5 * coarse if sigma > 1 else 0.0)
    start = np.indices(luma.shape).astype(float)
    along = tangent_at(tensor, start)
    normal = np.stack([along[1], -along[0]])
    pace = min(1.0, sigma / 2)
    sums, totals = [luma.copy(), luma.copy()], [1.0, 1.0]
    for number in range(1, int(np.ceil(3 * 1.6 * sigma / pace)) + 1):
        away = number * pace
        pair = sum(map_coordinates(luma, start + s * away * normal, order=1, mode="nearest") for s in (1, -1))
        for each, width in enumerate((sigma, 1.6 * sigma)):
            weight = np.exp(-(away**2) / (2 * width**2))
            sums[each] += weight * pair
            totals[each] += 2 * weight
    narrow, wide = (each / total for each, total in zip(sums, totals, strict=True))
    return integrate_along_lines(
        (1 + SHARPENING_FACTOR) * narrow - SHARPENING_FACTOR * wide, tensor, 1.5 * coarse
    )


def soft_threshold(picture: Picture, phi: float, epsilon: float) -> Picture:
    """Equation of the soft threshold, for luma 0..255."""
    return 1 + np.tanh(np.minimum(phi * (255 * picture - epsilon), 0))


def detail(luma: Picture, delta: float) -> Picture:
    """Section 5.4.4: layers of detail between non-local means of falling strength, with their factors."""
    strengths, factors = (40.0, 57.0, 80.0), (1.0, 0.5, 0.2)
    bases = [luma, *(nonlocal_means(luma, each / 255) for each in strengths)]
    layers = [finer - coarser for finer, coarser in zip(bases, bases[1:], strict=False)]
    return luma + sum(delta / 20 * factor * layer for factor, layer in zip(factors, layers, strict=True))


def nonlocal_means(luma: Picture, strength: float) -> Picture:
    """Average 9 x 9 pixels by the similarity of the squares of 3 x 3 around them (Buades et al. 2005)."""
    reach, (height, width) = 4, luma.shape
    padded = np.pad(luma, reach + 1, mode="edge")
    total, weights = np.zeros_like(luma), np.zeros_like(luma)
    squares = np.lib.stride_tricks.sliding_window_view(padded, (3, 3))
    middle = squares[reach : reach + height, reach : reach + width]
    for down, right in np.ndindex(2 * reach + 1, 2 * reach + 1):
        others = squares[down : down + height, right : right + width]
        unlike = np.square(middle - others).mean(axis=(2, 3))
        away = (down - reach) ** 2 + (right - reach) ** 2
        weight = np.exp(-unlike / (2 * strength**2) - away / (2 * 2.5**2))
        total += weight * others[..., 1, 1]
        weights += weight
    return total / weights


def cases() -> Iterator[tuple[fidelity.Case, str, Callable[[Picture], Picture]]]:
    """Yield settings of blocks with our reference, and the name and function of the independent one."""
    for passes in (1, 3):
        case = fidelity.stroke_case(passes, 2, 2, reselect=True, paper="")
        yield case, "", partial(edge_tangent_flow, sigma=2, rho=2, passes=passes)
    case = fidelity.stroke_case(6, 4, 4, brush="broad", reselect=True, paper="")
    yield case, "", partial(edge_tangent_flow, sigma=4, rho=4, passes=6)
    curvature = fidelity.Case("tvf", {"passes": 1}, partial(tv_flow, time=2))
    yield curvature, "central differences", lambda z: curvature_flow(z, 2)
    yield curvature, "medians of circles", lambda z: circle_median_flow(z, 2)
    for values in ({"delta": -20}, {"delta": 20}, {"delta": 20, "accurate": True}):
        delta = values["delta"]
        case = fidelity.Case("detail", dict(values), partial(fidelity.apply_detail, delta=delta))
        yield case, "", partial(detail, delta=delta)
    for sigma in (1, 1.4, 2, 4):
        outputs = ("clipped", "threshold")
        case = fidelity.Case(
            "flow_dog",
            {"sigma": sigma, "p": SHARPENING_FACTOR},
            partial(fidelity.apply_flow_dog, sigma=sigma),
            outputs,
        )
        yield case, "", partial(flow_dog, sigma=sigma)


def load_luma(name: str) -> Picture:
    """Return the luma of the center of a photograph, float32, 0..1."""
    picture = getattr(skimage.data, name)()
    luma = (picture @ [0.299, 0.587, 0.114] if picture.ndim == 3 else picture) / 255.0
    top, left = ((side - SIDE_PX) // 2 for side in luma.shape)
    middle = luma[max(top, 0) : max(top, 0) + SIDE_PX, left : left + SIDE_PX]
    return np.ascontiguousarray(middle, np.float32)


def measure_rows(case: fidelity.Case, name: str, reference: Callable[[Picture], Picture]) -> Iterator[str]:
    """Yield lines of the table: mean PSNR of the inner area of all photographs."""
    found: list[list[float]] = []
    for luma in map(load_luma, PHOTOGRAPHS):
        planes = luma, case.run.whole(luma), case.target(luma), reference(luma.astype(np.float64))
        for outputs in case.outputs:
            kind = outputs or "clipped"
            plain, result, ours, theirs = (
                crop_border(fidelity.convert_output(each, kind)) for each in planes
            )
            pairs = (
                (crop_border(luma) if outputs == "threshold" else plain, theirs),
                (result, theirs),
                (result, ours),
                (ours, theirs),
            )
            found.append([psnr(*pair) for pair in pairs])
    means = np.reshape(found, (len(PHOTOGRAPHS), len(case.outputs), 4)).mean(axis=0)
    for outputs, row in zip(case.outputs, means, strict=True):
        setting = ", ".join(filter(None, (case.name, name, outputs)))
        yield f"| `{case.block}` | {setting} | {' | '.join(f'{each:.1f} dB' for each in row)} |"


def crop_border(picture: Picture) -> Picture:
    """Return a picture without its border."""
    return picture[BORDER_PX:-BORDER_PX, BORDER_PX:-BORDER_PX]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="a block, or the beginning of its row: 'flow_dog sigma 2'")
    only = parser.parse_args().only
    print("| block | setting | untouched | block | block, from our reference | our reference |")
    print("|---" * 6 + "|")
    for case, name, reference in cases():
        if f"{case.block} {case.name}".startswith(only):
            print(*measure_rows(case, name, reference), sep="\n", flush=True)


if __name__ == "__main__":
    main()
