"""Tone mapping of HDR pictures to SDR: from PQ or HLG with BT.2020 primaries to BT.709.

The knee of ITU-R BT.2390 compresses the largest of R, G and B, which preserves hues. Reference white becomes
SDR white; colours outside BT.709 are clipped.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, cached_property
from typing import Any

import av
import numpy as np

from vidstyle.core.machine.cores import available_cores
from vidstyle.core.picture import Encoding, Picture
from vidstyle.errors import log
from vidstyle.media.color_tags import BT2020_PRIMARIES_CODE, HLG_CODE, LIMITED_RANGE, PQ_CODE, ColorTags
from vidstyle.media.exif import ByteView, png_chunks
from vidstyle.media.hdr_kernels import tone_map_colors, tone_map_planes

SDR_TAGS = ColorTags(1, 1, 1, LIMITED_RANGE)
TABLE_SIZE = 32768
"""Entries of a lookup table; sufficient for nearest-neighbour lookup of 12-bit signals."""
DEFAULT_PEAK_NITS = 1000.0
"""The usual peak of PQ masters in cd/m2, for streams that declare none."""
PROBE_SIZE_PX = 16
"""Width and height of the picture that is encoded to read the light levels."""
BT2020_TO_BT709_MATRIX = np.array(
    [[1.660491, -0.587641, -0.072850], [-0.124550, 1.132900, -0.008349], [-0.018151, -0.100579, 1.118730]],
    np.float32,
)
"""Conversion of linear light (ITU-R BT.2407, section 2)."""


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
        encoding = replace(picture.encoding, matrix="bt709", full_range=False)
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
        return replace(picture, color=out)

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
    """Return the declared peak luminance in cd/m2: MaxCLL, else the peak of the mastering display."""
    chunks = _light_chunks(frame)
    # In units of 0.0001 cd/m2. The peak of the mastering display follows its primaries and white point.
    levels = chunks.get(b"cLLI", b"")[:4], chunks.get(b"mDCV", b"")[16:20]
    nits = [int.from_bytes(level) / 10000 for level in levels]
    return next((level for level in nits if REFERENCE_WHITE_NITS < level <= 10000), DEFAULT_PEAK_NITS)


def _light_chunks(frame: av.VideoFrame) -> dict[bytes, ByteView]:
    """Return the chunks of a small PNG of the frame, to which FFmpeg's encoder copies the light levels.

    `frame.side_data` also holds them, but is not safe to read: see `orientation_of`.
    """
    try:
        small = frame.reformat(PROBE_SIZE_PX, PROBE_SIZE_PX, "rgb24")
        encoder: Any = av.CodecContext.create("png", "w")
        encoder.width = encoder.height = PROBE_SIZE_PX
        encoder.pix_fmt, encoder.time_base = "rgb24", Fraction(1)
        small.pts = 0
        return dict(png_chunks(b"".join(map(bytes, encoder.encode(small)))))
    except (av.FFmpegError, ValueError) as error:
        log.debug("the light levels of the film are unknown: %s", error)
        return {}


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


REFERENCE_WHITE_NITS = 203.0
"""Diffuse white of HDR in cd/m2 (ITU-R BT.2408), which becomes SDR white."""
HLG_PEAK_NITS = 1000.0
HLG_GAMMA = 1.2
"""The system gamma of HLG on a display of 1000 cd/m2 (ITU-R BT.2100, table 5)."""
SDR_GAMMA = 2.4
"""Gamma of the reference display for BT.709 (ITU-R BT.1886, black at zero)."""

_PQ_M1_EXPONENT, _PQ_M2_EXPONENT = 2610 / 16384, 2523 / 4096 * 128
_PQ_C1_COEFFICIENT, _PQ_C2_COEFFICIENT, _PQ_C3_COEFFICIENT = 3424 / 4096, 2413 / 4096 * 32, 2392 / 4096 * 32
_HLG_A_COEFFICIENT, _HLG_B_COEFFICIENT, _HLG_C_COEFFICIENT = 0.17883277, 0.28466892, 0.55991073


def pq_to_nits(signal: np.ndarray) -> np.ndarray:
    """Return the light of a PQ signal 0..1 in cd/m2 (SMPTE ST 2084)."""
    power = np.asarray(signal, np.float64) ** (1 / _PQ_M2_EXPONENT)
    return 10000 * (
        np.maximum(power - _PQ_C1_COEFFICIENT, 0) / (_PQ_C2_COEFFICIENT - _PQ_C3_COEFFICIENT * power)
    ) ** (1 / _PQ_M1_EXPONENT)


def nits_to_pq(nits: np.ndarray) -> np.ndarray:
    """Return the PQ signal 0..1 of light in cd/m2 (SMPTE ST 2084)."""
    power = np.clip(np.asarray(nits, np.float64) / 10000, 0, 1) ** _PQ_M1_EXPONENT
    return (
        (_PQ_C1_COEFFICIENT + _PQ_C2_COEFFICIENT * power) / (1 + _PQ_C3_COEFFICIENT * power)
    ) ** _PQ_M2_EXPONENT


def hlg_to_scene(signal: np.ndarray) -> np.ndarray:
    """Return the scene light 0..1 of an HLG signal 0..1 (ITU-R BT.2100)."""
    signal = np.asarray(signal, np.float64)
    return np.where(
        signal <= 0.5,
        signal**2 / 3,
        (np.exp((signal - _HLG_C_COEFFICIENT) / _HLG_A_COEFFICIENT) + _HLG_B_COEFFICIENT) / 12,
    )


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
