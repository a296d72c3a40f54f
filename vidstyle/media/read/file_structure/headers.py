"""Facts from file headers that FFmpeg does not expose before decoding: sizes, MP4 boxes, ends of files."""

from __future__ import annotations

import os
import re
import struct
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

HEADER_BYTES = 2**18
"""Bytes at the start of a file that contain the picture size."""


def picture_size(head: bytes) -> tuple[int, int] | None:
    """Return width and height in the header of a PNG, GIF, BMP or extended WebP; None for other content."""
    if head[:8] == b"\x89PNG\r\n\x1a\n" and len(head) >= 24:
        return struct.unpack(">II", head[16:24])
    if head[:4] == b"GIF8" and len(head) >= 10:
        return struct.unpack("<HH", head[6:10])
    if head[:2] == b"BM" and len(head) >= 26:
        width, height = struct.unpack("<ii", head[18:26])
        return abs(width), abs(height)
    if head[:4] == b"RIFF" and head[8:16] == b"WEBPVP8X" and len(head) >= 30:
        # 24 bits each, minus one (RFC 9649, section 2.7.1).
        return int.from_bytes(head[24:27], "little") + 1, int.from_bytes(head[27:30], "little") + 1
    return None


def is_jpeg(head: bytes) -> bool:
    """Whether the content starts as a JPEG picture."""
    return head[:3] == b"\xff\xd8\xff"


OTHER_PICTURE_ENDINGS = (
    ".webp",
    ".tif",
    ".tiff",
    ".bmp",
    ".ppm",
    ".qoi",
    ".dpx",
    ".exr",
    ".heic",
    ".avif",
    ".jxl",
)


def is_named_as_picture(path: Path) -> bool:
    """Whether the extension means one picture, so that only the first one in the file is shown.

    Cameras append previews, gain maps and films to photographs (CIPA DC-007, ISO 21496-1).
    """
    return path.suffix.lower() in (".jpg", ".jpeg", ".jpe", ".jfif", ".mpo", ".png")


def has_picture_ending(path: Path) -> bool:
    """Whether the extension is a picture's, including formats that may contain a film."""
    return is_named_as_picture(path) or path.suffix.lower() in OTHER_PICTURE_ENDINGS


def jpeg_ends_early(content: bytes) -> bool:
    """Whether a JPEG has no end-of-image marker after its first scan (ITU-T T.81, B.1.1)."""
    offset = 2
    while content[offset : offset + 1] == b"\xff" and content[offset + 1 : offset + 2] != b"\xda":
        offset += 2 + int.from_bytes(content[offset + 2 : offset + 4], "big")
    return b"\xff\xd9" not in content[offset:]


MAX_BOXES = 2**17
"""Maximum number of boxes to read: a film of 18 hours in fragments of a second has this many."""


def top_boxes(path: Path) -> Iterator[tuple[bytes, int, int]]:
    """Yield type, offset and size in bytes of each top-level box, up to the first invalid one."""
    end = path.stat().st_size
    with path.open("rb") as file:
        offset = 0
        for _ in range(MAX_BOXES):
            file.seek(offset)
            header = file.read(16)
            if len(header) < 8:
                return
            size, kind = int.from_bytes(header[:4], "big"), header[4:8]
            if size == 1:
                size = int.from_bytes(header[8:16], "big")
            elif size == 0:
                size = end - offset
            yield kind, offset, size
            if not 8 <= size <= end - offset:
                return
            offset += size


def has_no_index(path: Path) -> bool:
    """Whether the file starts as MP4 or MOV but has no "moov" box."""
    kinds = [kind for kind, _, _ in top_boxes(path)]
    return kinds[:1] in ([b"ftyp"], [b"wide"], [b"mdat"]) and b"moov" not in kinds


def ends_early(path: Path, formats: set[str]) -> bool:
    """Whether a file is truncated, or its structure is damaged.

    Formats that do not store where they end are treated as complete.
    """
    if "mp4" in formats:
        boxes = list(top_boxes(path))
        # Without fragments, the index lists every frame, and data after it does not matter.
        fragmented = len(boxes) < MAX_BOXES and any(kind == b"moof" for kind, _, _ in boxes)
        last, start, size = boxes[-1]
        return fragmented and not (last.isalnum() and start + size == path.stat().st_size)
    with path.open("rb") as file:
        try:
            return any(check(file) for name, check in _ENDS_EARLY.items() if name in formats)
        except (IndexError, struct.error):
            return True


def states_duration(path: Path) -> bool:
    """Whether the header of a Matroska file has the duration, which FFmpeg otherwise estimates."""
    with path.open("rb") as file:
        return re.search(rb"\x44\x89[\x84\x88]", file.read(HEADER_BYTES)) is not None


def _matroska_ends_early(file: BinaryIO) -> bool:
    end = _segment_end(file.read(HEADER_BYTES))
    return end is not None and end > _size(file)


def _segment_end(head: bytes) -> int | None:
    """Return the end of a Matroska file by its header; None: of unknown size (RFC 8794, section 6.2)."""
    before, identifier, after = head.partition(b"\x18\x53\x80\x67")
    if not after or not after[0]:
        return None
    length = 9 - after[0].bit_length()
    unknown = (1 << 7 * length) - 1
    segment = int.from_bytes(after[:length], "big") & unknown
    return None if segment == unknown else len(before + identifier) + length + segment


def _nut_ends_early(file: BinaryIO) -> bool:
    """The index is the last packet, and ends with its length (NUT specification, file structure)."""
    size = _size(file)
    file.seek(size - 12)
    file.seek(max(0, size - int.from_bytes(file.read(8), "big")))
    return file.read(8) != b"NX\xdd\x67\x2f\x23\xe6\x4e"


def _avi_ends_early(file: BinaryIO) -> bool:
    (length,) = struct.unpack("<I", file.read(8)[4:])
    # The length is -1 if the writer could not seek; some writers omit the padding byte.
    return length != 2**32 - 1 and length + 7 > _size(file)


def _gif_ends_early(file: BinaryIO) -> bool:
    """Follow the blocks to the trailer (GIF89a, section 15 and appendix A), also in concatenated files."""

    def skip(count: int) -> None:
        file.seek(count, os.SEEK_CUR)

    def skip_colors(flags: int) -> None:
        skip(6 << (flags & 7) if flags & 0x80 else 0)

    skip_colors(file.read(13)[10])
    while kind := file.read(1):
        if kind == b";":
            header = file.read(13)
            if header[:4] != b"GIF8":
                return False
            skip_colors(header[10])
            continue
        if kind == b",":
            skip_colors(file.read(9)[8:][0])
        elif kind != b"!":
            return True
        skip(1)
        while length := file.read(1):
            if length == b"\0":
                break
            skip(length[0])
    return True


def _ogg_ends_early(file: BinaryIO) -> bool:
    """The last page has the end-of-stream flag (RFC 3533, section 6)."""
    file.seek(max(0, _size(file) - HEADER_BYTES))
    _, _, last = file.read().rpartition(b"OggS")
    return not (len(last) > 1 and last[1] & 4)


FLV_SOUND_ID, FLV_VIDEO_ID, FLV_SCRIPT_ID = 8, 9, 18
"""Types of tags of an FLV file (Video File Format Specification 10.1, E.4.1)."""
FLV_COMMAND_ID, FLV_PACKET_IDS = 5, frozenset({1, 3})
"""Kind of frame that is a command to the player; kinds of content of Enhanced RTMP that are packets."""
FLV_EXTENDED_VIDEO_BIT, FLV_EXTENDED_SOUND_ID = 8, 9
"""Bit of the kind of frame, and codec of sound: a name of four letters follows (Enhanced RTMP)."""
FLV_CONFIGURED_IDS, FLV_AAC_ID = (b"\x07", b"\x0c"), b"\x0a"
"""Codecs of video (H.264, H.265) and sound whose second byte is 1 in packets."""
FLV_SAME = {b"avc1": b"\x07", b"hvc1": b"\x0c", b"mp4a": FLV_AAC_ID, b".mp3": b"\x02", b"\x0e": b"\x02"}
"""Names of a codec that has another one."""
ASF_HEADER = bytes.fromhex("3026b2758e66cf11a6d900aa0062ce6c")
"""Identifier of the object with which an ASF file begins (ASF specification, 10.1)."""


def flv_codecs(path: Path) -> dict[tuple[int, bytes], int]:
    """How many tags of video and sound an FLV file has, by type and codec, in the order of the first ones."""
    counts: Counter[tuple[int, bytes]] = Counter()
    with path.open("rb") as file:
        for kind, content in _flv_tags(file):
            if codec := _flv_codec(kind, content):
                counts[kind, FLV_SAME.get(codec, codec)] += 1
    return counts


def _flv_tags(file: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Type and first bytes of each tag, as far as they can be followed; the file then is where that ends."""
    offset = int.from_bytes(file.read(9)[5:]) + 4
    while True:
        file.seek(offset)
        header = file.read(16)
        kind = header[0] & 0x1F if len(header) > 11 else None
        if kind not in (FLV_SOUND_ID, FLV_VIDEO_ID, FLV_SCRIPT_ID):
            file.seek(offset)
            return
        size = int.from_bytes(header[1:4])
        yield kind, header[11:][:size]
        offset += 11 + size + 4


def _flv_codec(kind: int, content: bytes) -> bytes:
    """What names the codec of a tag, or nothing for one without a packet of it."""
    if kind == FLV_SCRIPT_ID or len(content) < 2:
        return b""
    high, low = divmod(content[0], 16)
    if kind == FLV_SOUND_ID and high != FLV_EXTENDED_SOUND_ID:
        codec = bytes([high])
        return codec if codec != FLV_AAC_ID or content[1] == 1 else b""
    if kind == FLV_VIDEO_ID and high & 7 == FLV_COMMAND_ID:
        return b""
    if kind == FLV_SOUND_ID or high & FLV_EXTENDED_VIDEO_BIT:
        return content[1:5] if low in FLV_PACKET_IDS else b""
    codec = bytes([low])
    return codec if codec not in FLV_CONFIGURED_IDS or content[1] == 1 else b""


def is_followed(path: Path, formats: set[str]) -> bool:
    """Whether another film begins where the structure of an FLV or ASF file ends; FFmpeg does not read it."""
    with path.open("rb") as file:
        if "flv" in formats:
            for _ in _flv_tags(file):
                pass
            return file.read(3) == b"FLV"
        return "asf" in formats and ASF_HEADER in list(_asf_objects(file))[1:]


def _asf_objects(file: BinaryIO) -> Iterator[bytes]:
    """The identifier of each outermost object, as far as they can be followed."""
    while len(header := file.read(24)) == 24:
        yield header[:16]
        if (size := int.from_bytes(header[16:], "little")) < 24 or size > _size(file):
            return
        file.seek(size - 24, os.SEEK_CUR)


_ENDS_EARLY: dict[str, Callable[[BinaryIO], bool]] = {
    "matroska": _matroska_ends_early,
    "nut": _nut_ends_early,
    "avi": _avi_ends_early,
    "gif": _gif_ends_early,
    "ogg": _ogg_ends_early,
}


def _size(file: BinaryIO) -> int:
    return os.fstat(file.fileno()).st_size
