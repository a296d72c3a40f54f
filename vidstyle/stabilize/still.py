"""Noise and JPEG blocks of a single picture, which has no other frames to remove them with."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from vidstyle.backend import FrameRequest
from vidstyle.core.bands import in_bands, shared_workers
from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.plain_codes import values_from_codes
from vidstyle.stabilize.dct_shrinkage import BLOCK_SIZE, shrink
from vidstyle.stabilize.still_noise import BRIGHTNESS_LEVELS, JPEG, PlaneNoise, StillNoise, measure_still

CHROMA_FACTOR = 1.3
"""Noise of chroma counts as stronger, as nobody misses fine detail in colours."""
STEP_DEVIATIONS = 0.25, 0.3
"""Error of luma and of chroma that JPEG makes, relative to the step of its quantization of luma. Tuned on
fidelity to four photographs before quality 25, and by eye on faces of 60 lines at quality 30."""
GUIDE_SIGMA_PX = 2
"""Standard deviation of the Gaussian that smooths the brightness by which the noise is looked up."""
MARGIN_PX = 48
"""Rows around a band that its result depends on."""


def flatten_still(request: FrameRequest, steady: float) -> FrameRequest:
    """Remove noise and JPEG blocks from a picture that stands alone.

    Styles would turn them into lines and specks. Keeps edges and alpha. `Stabilizer` does this for films.

    Args:
        steady: as in a style; 0 for no change.

    Returns:
        The same request if it is a frame of a film, or done already; the same picture if it is clean.
    """
    if not steady or request.time is not None or request.is_clean:
        return request
    noise = measure_still(request.picture)
    is_clean = not noise.planes and not noise.step
    return replace(
        request, picture=request.picture if is_clean else cleaned(request.picture, noise), is_clean=True
    )


def cleaned(picture: Picture, noise: StillNoise) -> Picture:
    """Return a picture without noise and JPEG blocks.

    Works in bands of rows, so that a large picture needs little memory.
    """
    changed = Picture(
        picture.encoding,
        None if picture.luma is None else np.empty_like(picture.luma),
        picture.chroma and (np.empty_like(picture.chroma[0]), np.empty_like(picture.chroma[1])),
        None if picture.color is None else np.empty_like(picture.color),
    )

    def run(top: int, bottom: int) -> None:
        first, last = max(top - MARGIN_PX, 0), min(bottom + MARGIN_PX, picture.shape[0])
        band, out = _rows(picture, first, last), _rows(changed, top, bottom)
        _clean_band(band, noise, top - first, out)

    in_bands(shared_workers(), picture.shape, MARGIN_PX, run, channels=1)
    return replace(picture, luma=changed.luma, chroma=changed.chroma, color=changed.color)


def _rows(picture: Picture, top: int, bottom: int) -> Picture:
    """Return the planes of rows `top`, a multiple of the chroma step, to `bottom`."""
    step = picture.encoding.subsampling[1]
    chroma = [plane[top // step : -(-bottom // step)] for plane in picture.chroma or ()]
    return Picture(
        picture.encoding,
        None if picture.luma is None else picture.luma[top:bottom],
        (chroma[0], chroma[1]) if chroma else None,
        None if picture.color is None else picture.color[top:bottom],
    )


def _clean_band(band: Picture, noise: StillNoise, top: int, out: Picture) -> None:
    """Write the cleaned planes of a band, without the first `top` rows, to `out`."""
    if band.color is not None:
        color = _levels(band.color, "color", band.encoding)
        planes = list(cv2.split(cv2.transform(color, JPEG.from_rgb)))
        changes = cv2.transform(cv2.merge(_changes(planes, noise)), JPEG.to_rgb)
        assert out.color is not None
        _write_changed(band.color, changes, "color", band.encoding, top, out.color)
        return
    assert band.luma is not None and out.luma is not None
    step = band.encoding.subsampling[1]
    given = [(band.luma, "luma", top, out.luma)]
    chroma = zip(band.chroma or (), out.chroma or (), strict=True)
    given += [(plane, "chroma", top // step, made) for plane, made in chroma]
    found = _changes([_levels(plane, kind, band.encoding) for plane, kind, _, _ in given], noise)
    for (plane, kind, first, made), change in zip(given, found, strict=True):
        _write_changed(plane, change, kind, band.encoding, first, made)


def _levels(plane: np.ndarray, kind: str, encoding: Encoding) -> np.ndarray:
    """Return samples in levels of 255, float32."""
    return np.float32(255) * values_from_codes(plane, kind, encoding)


def _write_changed(
    plane: np.ndarray, changes: np.ndarray, kind: str, encoding: Encoding, top: int, out: np.ndarray
) -> None:
    """Write the rows of a plane from `top` on, plus changes in levels of 255, as codes."""
    rows = slice(top, top + out.shape[0])
    black, white = encoding.luma_levels
    span = encoding.chroma_levels[1] if kind == "chroma" else white - black
    codes = plane[rows] + changes[rows] * np.float32(span / 255)
    most = 2**encoding.depth - 1
    out[...] = codes if encoding.depth == 0 else np.clip(np.rint(codes), 0, most)


def _changes(planes: list[np.ndarray], noise: StillNoise) -> list[np.ndarray]:
    """Return what to add to luma and both chroma planes, in levels of 255."""
    luma, *chroma = planes
    guide = cv2.GaussianBlur(luma, (0, 0), GUIDE_SIGMA_PX)
    brightness = np.clip(np.rint(guide), 0, 255).astype(np.uint8)
    each = noise.planes or (None,) * len(planes)
    error, color_error = (noise.step * share for share in STEP_DEVIATIONS)
    deviations = _deviations(brightness, each[0], 1, error)
    made = [shrink(luma, deviations, _factors(each[0])) - luma]
    for plane, own in zip(chroma, each[1:], strict=True):
        light = cv2.resize(brightness, plane.shape[::-1], interpolation=cv2.INTER_AREA)
        made.append(_chroma_change(plane, light, own, color_error, plane.shape == luma.shape))
    return made


def _chroma_change(
    plane: np.ndarray, brightness: np.ndarray, noise: PlaneNoise | None, error: float, is_fine: bool
) -> np.ndarray:
    """Return what to add to a chroma plane; where it is as fine as luma, also noise of half its size goes."""
    factors = _factors(noise)
    change = shrink(plane, _deviations(brightness, noise, CHROMA_FACTOR, error), factors) - plane
    if is_fine:
        half = _halved(plane + change)
        # Noise that differs in each pixel has half its deviation in a copy of half the size.
        share = CHROMA_FACTOR / 2 * float(factors[0, 1])
        light = cv2.resize(brightness, half.shape[::-1], interpolation=cv2.INTER_NEAREST)
        coarse = shrink(half, _deviations(light, noise, share, error), np.ones_like(factors)) - half
        height, width = plane.shape
        change += cv2.resize(coarse, None, fx=2, fy=2, interpolation=cv2.INTER_LINEAR)[:height, :width]
    return change


def _halved(plane: np.ndarray) -> np.ndarray:
    """Return a plane of half the size; an odd row or column is repeated."""
    height, width = plane.shape
    even = cv2.copyMakeBorder(plane, 0, height % 2, 0, width % 2, cv2.BORDER_REPLICATE)
    return cv2.resize(even, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)


def _deviations(brightness: np.ndarray, noise: PlaneNoise | None, factor: float, least: float) -> np.ndarray:
    """Return the deviation at each pixel by its brightness: `factor` times the noise, at least `least`."""
    found = np.zeros(256)
    if noise is not None:
        centers = (np.arange(BRIGHTNESS_LEVELS) + 0.5) * (256 / BRIGHTNESS_LEVELS)
        found = np.interp(np.arange(256), centers, factor * noise.deviations)
    return cv2.LUT(brightness, np.maximum(found, least).astype(np.float32))


def _factors(noise: PlaneNoise | None) -> np.ndarray:
    return np.ones((BLOCK_SIZE, BLOCK_SIZE), np.float32) if noise is None else noise.factors
