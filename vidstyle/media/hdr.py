"""Tone mapping of HDR pictures to SDR: from PQ or HLG with BT.2020 primaries to BT.709.

The knee of ITU-R BT.2390 compresses the largest of R, G and B, which preserves hues. Reference white becomes
SDR white; colours outside BT.709 are clipped.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cache, cached_property

import av
import numpy as np

from vidstyle.core.color.hdr_curves import (
    BT2020_TO_BT709_MATRIX,
    HLG_GAMMA,
    HLG_PEAK_NITS,
    REFERENCE_WHITE_NITS,
    SDR_GAMMA,
    hlg_to_scene,
    nits_to_pq,
    pq_to_nits,
)
from vidstyle.core.machine.cores import available_cores
from vidstyle.core.picture import Encoding, Picture
from vidstyle.media.color_tags import BT2020_PRIMARIES_CODE, HLG_CODE, LIMITED_RANGE, PQ_CODE, ColorTags
from vidstyle.media.hdr_kernels import tone_map_colors, tone_map_planes
from vidstyle.media.hdr_metadata import MAX_NITS, read_metadata

SDR_TAGS = ColorTags(1, 1, 1, LIMITED_RANGE)
TABLE_SIZE = 32768
"""Entries of a lookup table; sufficient for nearest-neighbour lookup of 12-bit signals."""
DEFAULT_PEAK_NITS = 1000.0
"""The usual peak of PQ masters in cd/m2, for streams that declare none."""


@dataclass(frozen=True)
class ToneMap:
    """Tone-maps pictures of one transfer and peak to SDR.

    Attributes:
        transfer: H.273 code of PQ or HLG.
        peak: peak luminance of a PQ source in cd/m2.
        wide: whether the primaries are BT.2020, otherwise BT.709.
    """

    transfer: int
    peak: float = DEFAULT_PEAK_NITS
    wide: bool = True

    @classmethod
    def of(cls, frame: av.VideoFrame, tags: ColorTags) -> ToneMap:
        """Return the tone map for a stream that starts with this frame."""
        peak = HLG_PEAK_NITS if tags.transfer == HLG_CODE else read_peak_nits(frame)
        return cls(tags.transfer, peak, tags.primaries in (0, 2, BT2020_PRIMARIES_CODE))

    @property
    def description(self) -> str:
        """The kind of HDR, for messages."""
        return "HLG" if self.transfer == HLG_CODE else f"PQ, up to {self.peak:g} cd/m2"

    def apply(self, picture: Picture) -> Picture:
        """Return the picture in SDR: limited-range BT.709 with depth and subsampling kept, or full-range RGB.

        Gray pictures are treated as RGB with equal channels.
        """
        if picture.color is not None:
            return self._colors(picture, picture.color)
        assert picture.luma is not None
        height, width = picture.shape
        encoding = replace(picture.encoding, matrix="bt709", full_range=False, transfer="sdr")
        encoding = replace(encoding, siting=(0.0, (encoding.subsampling[1] - 1) / 2))
        neutral = np.full((height, width), picture.encoding.chroma_levels[0], picture.luma.dtype)
        blue, red = picture.chroma or (neutral, neutral)
        shape = encoding.chroma_shape(height, width)
        luma, new_blue, new_red = (
            np.empty(size, picture.luma.dtype) for size in ((height, width), shape, shape)
        )
        planes, out = (picture.luma, blue, red), (luma, new_blue, new_red)
        levels = _levels(picture.encoding), _levels(encoding)
        matrices = picture.encoding.to_rgb, encoding.from_rgb
        place = np.array([*encoding.subsampling, *picture.encoding.siting], np.float32)

        def run(first: int, end: int) -> None:
            rows = np.empty((2, blue.shape[1]), np.float32), np.empty((2, width), np.float32)
            tone_map_planes(planes, out, first, end, levels, matrices, place, self._tables, rows)

        _run_in_strips(run, height, encoding.subsampling[1])
        chroma = None if picture.chroma is None else (new_blue, new_red)
        return Picture(encoding, luma=luma, chroma=chroma, alpha=picture.alpha)

    def _colors(self, picture: Picture, color: np.ndarray) -> Picture:
        out = np.empty_like(color, order="C")
        top = picture.encoding.luma_levels[1]
        _run_in_strips(
            lambda first, end: tone_map_colors(color, out, first, end, top, self._tables), color.shape[0], 1
        )
        encoding = replace(picture.encoding, matrix="bt709", transfer="sdr")
        return replace(picture, encoding=encoding, color=out)

    @cached_property
    def _tables(self) -> tuple[np.ndarray, ...]:
        """Tables of light in units of reference white, gain, HLG's OOTF, gamut matrix and display gamma."""
        signal = np.linspace(0, 1, TABLE_SIZE)
        display = (signal**2) ** (1 / SDR_GAMMA)
        gamut = BT2020_TO_BT709_MATRIX if self.wide else np.eye(3, dtype=np.float32)
        if self.transfer == PQ_CODE:
            nits = pq_to_nits(signal)
            light, gain, ootf = nits / REFERENCE_WHITE_NITS, _gain(nits, self.peak), np.empty(0)
        else:
            light, ootf = hlg_to_scene(signal), (signal**4) ** (HLG_GAMMA - 1)
            gain = _gain(signal**4 * HLG_PEAK_NITS, HLG_PEAK_NITS) * HLG_PEAK_NITS / REFERENCE_WHITE_NITS
        tables = (light, gain, ootf, gamut, display)
        return tuple(np.ascontiguousarray(table, np.float32) for table in tables)


def read_peak_nits(frame: av.VideoFrame) -> float:
    """Return the declared peak luminance in cd/m2, if it is plausible, else the usual one."""
    metadata = read_metadata(frame)
    light = metadata.content_light[0] if metadata.content_light else 0
    display = metadata.mastering.max_nits if metadata.mastering else 0
    nits = (level for level in (light, display) if REFERENCE_WHITE_NITS < level <= MAX_NITS)
    return next(nits, DEFAULT_PEAK_NITS)


def _gain(nits: np.ndarray, peak: float) -> np.ndarray:
    """Return the gain of light; 1 near black."""
    return compress_nits(nits, peak) / np.maximum(nits, 1e-9) * (nits > 1e-6) + (nits <= 1e-6)


def _levels(encoding: Encoding) -> np.ndarray:
    black, white = encoding.luma_levels
    neutral, span = encoding.chroma_levels
    return np.array([black, white - black, neutral, span], np.float32)


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(available_cores(), "tone mapping")


def _run_in_strips(run: Callable[[int, int], None], height: int, step: int) -> None:
    """Process all rows in one strip per processor; strips begin at chroma rows."""
    count = min(available_cores(), max(1, height // 64))
    cuts = [round(height * number / count / step) * step for number in range(count)] + [height]
    if count == 1:
        run(0, height)
    else:
        list(_pool().map(run, cuts[:-1], cuts[1:]))


def compress_nits(nits: np.ndarray, peak: float, target: float = REFERENCE_WHITE_NITS) -> np.ndarray:
    """Compress light up to `peak` below `target`, both in cd/m2 (ITU-R BT.2390, section 5.4.1).

    The knee is a Hermite spline in PQ; darker light is unchanged, and black stays zero.
    """
    top = float(nits_to_pq(np.array(peak)))
    highest = float(nits_to_pq(np.array(target))) / top
    signal = np.minimum(nits_to_pq(nits) / top, 1)
    if highest >= 1:
        return pq_to_nits(signal * top)
    start = 1.5 * highest - 0.5
    t = np.clip((signal - start) / (1 - start), 0, 1)
    bent = (
        (2 * t**3 - 3 * t**2 + 1) * start
        + (t**3 - 2 * t**2 + t) * (1 - start)
        + (-2 * t**3 + 3 * t**2) * highest
    )
    return pq_to_nits(np.where(signal < start, signal, bent) * top)
