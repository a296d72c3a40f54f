"""Measures the noise of a single picture, and how coarsely JPEG has quantized it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.plain_codes import values_from_codes
from vidstyle.core.sampling import percentiles
from vidstyle.stabilize.dct_shrinkage import BLOCK_SIZE, dct_matrix

JPEG = Encoding("bt601", full_range=True)
"""The matrix of JPEG, in which RGB pictures are measured and cleaned."""
MIN_SIDE = 2 * BLOCK_SIZE
"""Smaller pictures are not measured."""
MAX_BLOCKS = 8000
"""Number of blocks that are measured at most."""
MAX_FEW_BLOCKS, OVERLAP_PX = 500, BLOCK_SIZE // 2
"""Number of blocks up to which they overlap, and by how many pixels."""
MIN_BLOCKS = 40
"""Number of blocks of similar brightness, or coefficients of one frequency, that allow an estimate."""

# Noise, in levels of 255.
BRIGHTNESS_LEVELS = 8
"""Number of levels of brightness at which noise is measured."""
CALM_SHARE = 0.15
"""Share of the blocks of a level that count, the calmest: most of a picture may be texture."""
MIN_BAND_POSITIONS = 3, 6, 10
"""Sums of a coefficient's two frequencies from which the bands of the spectrum begin; below is shading."""
MAX_LOWEST_FACTOR = 1.5
"""Noise below the first band relative to it, at most; it is extrapolated from the first two bands."""
LEAST_NOISY_SHARE = 0.25
"""Share of a picture that may have less noise than estimated; noise of areas full of texture is not known."""
MIN_NOISE_LEVELS = 5.0, 3.0, 3.0
"""Noise in each band, relative to the contrast, below which a picture is clean. 60 of 64 photographs have
at most 4.9, 2.8 and 1.8; in three others noise is visible at full size, and in one blocks."""
MAX_BAND_RATIO = 2.3
"""Largest ratio of the first two bands in noise of cameras, which they smooth; fur and grass have more."""
DEVIATION_RANGE = 0.5, 2.5
"""Noise of a level relative to the estimate for the picture: dark areas have more, and clipped ones less."""
MIN_CONTRAST = 0.3
"""Contrast below which it is not taken into account, relative to the distance from black to white."""
DARKEST_PERCENTILE = 2
"""Percentile of the darkest samples that count for the contrast; the same share of the brightest does not."""

# Quantization of JPEG, in levels of 255.
MIN_STEP = 12.0
"""Step, relative to the contrast, below which its traces are faint; quality 60 has 10."""
STEP_RANGE = range(8, 101)
"""Steps that are found; quality 6 has 100."""
MULTIPLE_RANGE = 0.4, 12.5
"""Coefficients that count, relative to the step: zeros, but for rounding, fit every step."""
MIN_COMB = 0.5
"""How closely coefficients match multiples of the step: 1 for exactly, 0 for anywhere."""
JPEG_POSITIONS = (0, 1), (1, 0), (1, 1)
"""Coefficients whose steps are found; other steps of the table are similar."""

MAX_LINES = 64
"""Number of rows, and of columns, in which the corner of JPEG's blocks is searched."""

_DCT = dct_matrix()
_BANDS = np.digitize(np.add.outer(np.arange(BLOCK_SIZE), np.arange(BLOCK_SIZE)), MIN_BAND_POSITIONS)
"""Band of each coefficient, from 1 on; 0: below all bands."""


class PlaneNoise(NamedTuple):
    """Noise of a plane, in levels of 255.

    Attributes:
        deviations: standard deviation at each level of brightness, `BRIGHTNESS_LEVELS` float32.
        bands: standard deviation in each band of the spectrum, for the whole plane, float32.
    """

    deviations: np.ndarray
    bands: np.ndarray

    @property
    def factors(self) -> np.ndarray:
        """Noise at each frequency relative to `deviations`, 8 x 8 float32."""
        first, second, *_ = bands = np.maximum(self.bands, np.float32(1e-3))
        lowest = first * np.clip(np.sqrt(first / second), 1, MAX_LOWEST_FACTOR)
        relative = np.array([lowest, *bands], np.float32) / _root_mean_square(bands)
        return np.asarray(relative[_BANDS])


class StillNoise(NamedTuple):
    """Defects of a picture.

    Attributes:
        planes: noise of luma and, if there is colour, of both chroma planes; empty if it is faint.
        step: of JPEG's quantization, in levels of 255; 0 if its traces are faint.
    """

    planes: tuple[PlaneNoise, ...]
    step: float


def measure_still(picture: Picture) -> StillNoise:
    """Measure the noise of a picture, and the traces of JPEG."""
    if min(picture.shape) < MIN_SIDE:
        return StillNoise((), 0)
    contrast = _contrast(picture)
    luma, *chroma = (_plane_noise(blocks, brightness) for blocks, brightness in _sampled_planes(picture))
    is_noisy = luma is not None and _is_noise(luma.bands / contrast)
    # Small chroma planes, which cannot be measured, have the noise of luma.
    planes = (luma, *(each or luma for each in chroma)) if luma and is_noisy else ()
    step = _jpeg_step(picture)
    return StillNoise(planes, step if step > MIN_STEP * contrast else 0)


def _is_noise(bands: np.ndarray) -> bool:
    """Return whether noise with these standard deviations of its bands is visible."""
    first, *others = bands.tolist()
    certain = min(first, MAX_BAND_RATIO * others[0]), *others
    return any(level > least for level, least in zip(certain, MIN_NOISE_LEVELS, strict=True))


def _contrast(picture: Picture) -> float:
    """Return the difference of dark and bright, 0..1: styles stretch low contrast, and its noise."""
    plane = picture.luma if picture.color is None else picture.color[..., 1]
    assert plane is not None
    dark, bright = percentiles(plane[::4, ::4], (DARKEST_PERCENTILE, 100 - DARKEST_PERCENTILE))
    black, white = picture.encoding.luma_levels
    return max(float(bright - dark) / (white - black), MIN_CONTRAST)


def _plane_noise(blocks: np.ndarray, brightness: np.ndarray) -> PlaneNoise | None:
    """Return the noise in the calmest blocks, N x 8 x 8, of this brightness, N; None if they are too few."""
    levels = (brightness * (BRIGHTNESS_LEVELS / 256)).astype(int)
    levels[(brightness <= 1) | (brightness >= 254)] = -1  # clipped
    counts = np.bincount(levels[levels >= 0], minlength=BRIGHTNESS_LEVELS)
    known = np.flatnonzero(counts >= MIN_BLOCKS)
    if not known.size:
        return None
    spectra = np.array([_spectrum(blocks[levels == level]) for level in known])
    bands = _weighted_quantile(spectra, counts[known])
    whole = _root_mean_square(bands)
    least, most = DEVIATION_RANGE
    each = np.clip([_root_mean_square(spectrum) for spectrum in spectra], least * whole, most * whole)
    deviations = np.interp(np.arange(BRIGHTNESS_LEVELS), known, each)
    return PlaneNoise(deviations.astype(np.float32), bands)


def _spectrum(blocks: np.ndarray) -> np.ndarray:
    """Return the standard deviation of each band in the calmest blocks, N x 8 x 8."""
    squares = (_DCT @ blocks @ _DCT.T) ** 2
    energy = squares.sum((1, 2)) - squares[:, 0, 0]
    calm = squares[energy <= percentiles(energy, (100 * CALM_SHARE,))[0]]
    bands = [calm[:, _BANDS == band].mean() for band in range(1, len(MIN_BAND_POSITIONS) + 1)]
    return np.sqrt(np.array(bands, np.float32))


def _weighted_quantile(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the quantile `LEAST_NOISY_SHARE` of each column."""
    order = np.argsort(values, axis=0)
    below = np.cumsum(weights[order], axis=0) / weights.sum()
    rows = (below < LEAST_NOISY_SHARE).sum(axis=0)
    return np.asarray(np.take_along_axis(values, order, 0)[rows, np.arange(values.shape[1])])


def _root_mean_square(bands: np.ndarray) -> np.float32:
    return np.sqrt(np.mean(np.square(bands), dtype=np.float32))


def _jpeg_step(picture: Picture) -> float:
    """Return the mean step of quantization of JPEG, in levels of 255; 0 if there are no traces of it.

    Coefficients of JPEG's blocks are multiples of their step, also after the picture was saved in another
    format, as Fan and de Queiroz 2003, "Identification of bitmap compression history", find.
    """
    blocks = _luma_blocks(picture, *_grid(picture.shape, _block_corner(picture)))
    coefficients = np.abs(_DCT @ blocks @ _DCT.T)
    steps = [_comb_step(coefficients[:, row, column]) for row, column in JPEG_POSITIONS]
    return float(np.mean(steps)) if all(steps) else 0.0


def _comb_step(sizes: np.ndarray) -> float:
    """Return the largest step of whose multiples the sizes of a coefficient are; 0 if there is none."""
    steps = np.array(STEP_RANGE, np.float32)
    ratios = sizes[:, None] / steps
    counted = (ratios > MULTIPLE_RANGE[0]) & (ratios < MULTIPLE_RANGE[1])
    counts = counted.sum(axis=0)
    combs = (np.cos(2 * np.pi * ratios) * counted).sum(axis=0) / np.maximum(counts, 1)
    matching = steps[(combs > MIN_COMB) & (counts >= MIN_BLOCKS)]
    return float(matching.max(initial=0))


def _block_corner(picture: Picture) -> tuple[int, int]:
    """Return where JPEG's blocks begin in a picture that may be cropped: the row and the column, 0..7."""
    height, width = picture.shape
    rows, columns = (np.arange(0, side, -(-side // MAX_LINES)) for side in (height, width))
    plane = picture.luma if picture.color is None else picture.color[..., 1]
    assert plane is not None
    return _phase(plane[:, columns].T), _phase(plane[rows])


def _phase(lines: np.ndarray) -> int:
    """Return the phase, 0..7, at which neighbours along lines, N x M, differ most."""
    steps = np.abs(np.diff(lines.astype(np.float32), axis=1)).mean(axis=0)
    edges = steps[1:-1] - (steps[:-2] + steps[2:]) / 2
    whole = edges[: edges.size // BLOCK_SIZE * BLOCK_SIZE].reshape(-1, BLOCK_SIZE)
    return (int(whole.mean(axis=0).argmax()) + 2) % BLOCK_SIZE if whole.size else 0


def _grid(shape: tuple[int, ...], corner: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return rows and columns at which blocks begin, evenly over a plane; they overlap in small ones."""
    blocks = shape[0] * shape[1] / BLOCK_SIZE**2
    step = BLOCK_SIZE * math.ceil(math.sqrt(blocks / MAX_BLOCKS)) if blocks > MAX_FEW_BLOCKS else OVERLAP_PX
    row, column = corner
    last = shape[0] - BLOCK_SIZE + 1, shape[1] - BLOCK_SIZE + 1
    return np.arange(row, last[0], step), np.arange(column, last[1], step)


def _sampled_planes(picture: Picture) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield blocks of luma, and of both chroma planes, N x 8 x 8, each with their brightness, N."""
    middle = BLOCK_SIZE // 2, BLOCK_SIZE // 2  # across the edges of JPEG's blocks
    rows, columns = _grid(picture.shape, middle)
    luma = _luma_blocks(picture, rows, columns)
    yield luma, luma.mean((1, 2))
    if picture.color is not None:
        colors = _blocks(picture.color, "color", picture.encoding, rows, columns)
        for weights in JPEG.from_rgb[1:]:
            yield colors @ weights, luma.mean((1, 2))
    across, down = picture.encoding.subsampling
    for plane in picture.chroma or ():
        rows, columns = _grid(plane.shape, middle)
        blocks = _blocks(plane, "chroma", picture.encoding, rows, columns)
        most = picture.shape[0] - BLOCK_SIZE, picture.shape[1] - BLOCK_SIZE
        over = np.minimum(down * rows, most[0]), np.minimum(across * columns, most[1])
        yield blocks, _luma_blocks(picture, *over).mean((1, 2))


def _luma_blocks(picture: Picture, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return the blocks of luma that begin at these rows and columns, N x 8 x 8, in levels of 255."""
    if picture.color is not None:
        return _blocks(picture.color, "color", picture.encoding, rows, columns) @ JPEG.weights
    assert picture.luma is not None
    return _blocks(picture.luma, "luma", picture.encoding, rows, columns)


def _blocks(
    plane: np.ndarray, kind: str, encoding: Encoding, rows: np.ndarray, columns: np.ndarray
) -> np.ndarray:
    """Return the blocks that begin at these rows and columns, N x 8 x 8 or N x 8 x 8 x 3."""
    if not rows.size or not columns.size:
        return np.empty((0, BLOCK_SIZE, BLOCK_SIZE, *plane.shape[2:]), np.float32)
    windows = sliding_window_view(plane, (BLOCK_SIZE, BLOCK_SIZE), axis=(0, 1))[np.ix_(rows, columns)]
    chosen = windows.reshape(-1, *windows.shape[2:])
    chosen = chosen if plane.ndim == 2 else np.moveaxis(chosen, 1, -1)
    return 255 * values_from_codes(chosen, kind, encoding)
