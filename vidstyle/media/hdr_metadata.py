"""Metadata of HDR streams: mastering display and light levels, and dynamic metadata, which is not kept."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import chain
from typing import Any

import av

from vidstyle.errors import log
from vidstyle.media.exif import ByteView, png_chunks

PROBE_SIZE_PX = 16
"""Width and height of the picture that is encoded to read the light levels."""
PNG_LUMINANCE_STEP = 10_000
"""Units of luminance in PNG per 1 cd/m2."""
MIN_PLAUSIBLE_PEAK_NITS, MAX_NITS = 50, 10_000
Chromaticity = tuple[float, float]


@dataclass(frozen=True)
class MasteringDisplay:
    """The display on which a film was graded (SMPTE ST 2086).

    Attributes:
        red, green, blue, white: CIE 1931 x and y.
        max_nits, min_nits: luminance in cd/m2.
    """

    red: Chromaticity
    green: Chromaticity
    blue: Chromaticity
    white: Chromaticity
    max_nits: float
    min_nits: float

    @property
    def problem(self) -> str:
        """The implausible value, in words, or an empty text."""
        if not (self.red[0] > self.green[0] > 0 and self.green[1] > self.blue[1] and self.white[1] > 0):
            return "its primaries are missing or in the wrong order"
        if not MIN_PLAUSIBLE_PEAK_NITS <= self.max_nits <= MAX_NITS or self.min_nits >= self.max_nits:
            return f"its peak is {self.max_nits:g} cd/m2"
        return ""

    def is_close(self, other: MasteringDisplay) -> bool:
        """Whether it is the same display, up to the rounding of codecs."""
        places = zip(self._numbers(), other._numbers(), strict=True)
        return all(math.isclose(one, two, rel_tol=1e-3, abs_tol=1e-4) for one, two in places)

    def _numbers(self) -> tuple[float, ...]:
        return (*self.red, *self.green, *self.blue, *self.white, self.max_nits, self.min_nits)


@dataclass(frozen=True)
class HdrMetadata:
    """Static metadata of an HDR stream.

    Attributes:
        mastering: the mastering display, if known.
        content_light: largest luminance of a pixel and largest mean of a frame in cd/m2 (MaxCLL, MaxFALL;
            CTA-861.3), if known.
    """

    mastering: MasteringDisplay | None = None
    content_light: tuple[int, int] | None = None

    def plausible(self) -> HdrMetadata:
        """Return it without implausible parts, each of which is reported."""
        found, light = self, self.content_light
        if self.mastering is not None and self.mastering.problem:
            log.warning("the mastering display metadata is dropped: %s", self.mastering.problem)
            found = replace(found, mastering=None)
        if light is not None and not MIN_PLAUSIBLE_PEAK_NITS <= light[0] <= MAX_NITS:
            log.warning("the content light levels are dropped: the maximum is %d cd/m2", light[0])
            found = replace(found, content_light=None)
        elif light is not None and light[1] > light[0]:
            log.warning("the content light levels are dropped: a mean of %d exceeds %d cd/m2", *light[::-1])
            found = replace(found, content_light=None)
        return found


def read_metadata(frame: av.VideoFrame) -> HdrMetadata:
    """Return the static metadata of a decoded frame."""
    chunks = _light_chunks(frame)
    # PyAV ends the process if it frees the side data of a frame with an ICC profile: see `orientation_of`.
    # The PNG itself lacks chromaticities, as FFmpeg 8 writes them over each other.
    display = None if b"iCCP" in chunks else _mastering_display(frame)
    return HdrMetadata(display, _content_light(chunks.get(b"cLLI")))


def _mastering_display(frame: av.VideoFrame) -> MasteringDisplay | None:
    """Parse FFmpeg's AVMasteringDisplayMetadata: ten rationals, and two flags of what FFmpeg trusts."""
    side_data: Any = frame.side_data.get("MASTERING_DISPLAY_METADATA")
    if side_data is None:
        return None
    numbers = struct.unpack_from("=20i", bytes(side_data))
    values = [
        top / bottom if bottom else 0.0 for top, bottom in zip(numbers[::2], numbers[1::2], strict=True)
    ]
    red, green, blue, white = zip(values[:8:2], values[1:8:2], strict=True)
    return MasteringDisplay(red, green, blue, white, max_nits=values[9], min_nits=values[8])


def _content_light(chunk: ByteView | None) -> tuple[int, int] | None:
    if chunk is None or len(chunk) < 8:
        return None
    most, mean = (round(each / PNG_LUMINANCE_STEP) for each in struct.unpack(">2I", chunk[:8]))
    return (most, mean) if most else None  # 0: unknown


def _light_chunks(frame: av.VideoFrame) -> dict[bytes, ByteView]:
    """Return the chunks of a small PNG of the frame, to which FFmpeg's encoder copies the light levels."""
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


HDR10_PLUS_MARK = bytes.fromhex("b5003c000104")
"""Start of an HDR10+ message: country and provider (ITU-T T.35), then ST 2094-40."""
DOLBY_VISION_AV1_MARK = bytes.fromhex("b5003b00000800")
DOLBY_VISION_NAL_CODE = 62
HEVC_NAL_LENGTH_BYTES = 4


def dynamic_metadata(packet: ByteView, codec: str) -> list[str]:
    """Return the names of the dynamic metadata in a packet of HEVC or AV1.

    >>> dynamic_metadata(bytes.fromhex("000000024e01b5003c00010400"), "av1")
    ['HDR10+']
    """
    content = bytes(packet)
    if codec == "hevc":
        is_dolby_vision = DOLBY_VISION_NAL_CODE in _nal_types(content)
    else:
        is_dolby_vision = DOLBY_VISION_AV1_MARK in content
    found = {"HDR10+": HDR10_PLUS_MARK in content, "Dolby Vision": is_dolby_vision}
    return [name for name, is_present in found.items() if is_present]


def _nal_types(content: bytes) -> set[int]:
    """Return the types of the NAL units of HEVC, after lengths of 4 bytes or after start codes."""
    by_length, offset = set(), 0
    while offset + HEVC_NAL_LENGTH_BYTES < len(content):
        by_length.add(content[offset + HEVC_NAL_LENGTH_BYTES] >> 1 & 63)
        offset += HEVC_NAL_LENGTH_BYTES + int.from_bytes(content[offset : offset + HEVC_NAL_LENGTH_BYTES])
    if offset == len(content):
        return by_length
    return {unit[0] >> 1 & 63 for unit in content.split(b"\0\0\1")[1:] if unit}


def first_metadata(path: str, stream_index: int) -> tuple[HdrMetadata, list[str]]:
    """Return the metadata at the start of a film, and the names of its dynamic metadata.

    Later frames, from which a film may be read, need not have it.
    """
    with av.open(path) as container:
        stream = container.streams[stream_index]
        assert isinstance(stream, av.VideoStream)
        names: list[str] | None = None
        for packet in chain(container.demux(stream)):
            if names is None and packet.size:
                names = dynamic_metadata(memoryview(packet), stream.codec_context.codec.canonical_name)
            for frame in _frames(packet):
                return read_metadata(frame), names or []
    return HdrMetadata(), []


def _frames(packet: av.Packet) -> Iterator[av.VideoFrame]:
    try:
        yield from (frame for frame in packet.decode() if isinstance(frame, av.VideoFrame))
    except av.FFmpegError as error:
        log.debug("a packet at the start of the film cannot be decoded: %s", error)
