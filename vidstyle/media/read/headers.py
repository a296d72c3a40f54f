"""Facts from file headers that FFmpeg does not give before decoding: sizes, MP4 boxes, where files end."""

from __future__ import annotations

import os
import re
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

HEADER_BYTES = 2**18
"""Bytes at the start of a file that contain the size of the picture."""


def picture_size(head: bytes) -> tuple[int, int] | None:
    """Width and height that a PNG, GIF, BMP or extended WebP announces; None for other content."""
    if head[:8] == b"\x89PNG\r\n\x1a\n" and len(head) >= 24:
        return struct.unpack(">II", head[16:24])
    if head[:4] == b"GIF8" and len(head) >= 10:
        return struct.unpack("<HH", head[6:10])
    if head[:2] == b"BM" and len(head) >= 26:
        width, height = struct.unpack("<ii", head[18:26])
        return abs(width), abs(height)
    if head[:4] == b"RIFF" and head[8:16] == b"WEBPVP8X" and len(head) >= 30:
        # 24 bits each, less one (RFC 9649, section 2.7.1).
        return int.from_bytes(head[24:27], "little") + 1, int.from_bytes(head[27:30], "little") + 1
    return None


def is_jpeg(head: bytes) -> bool:
    """Whether the content is a JPEG picture."""
    return head[:3] == b"\xff\xd8\xff"


OTHER_PICTURES = (".webp", ".tif", ".tiff", ".bmp", ".ppm", ".qoi", ".dpx", ".exr", ".heic", ".avif", ".jxl")


def is_named_as_picture(path: Path) -> bool:
    """Whether the name promises one picture, so that what follows the first one in the file is not shown.

    Cameras append previews, gain maps and films to photographs (CIPA DC-007, ISO 21496-1).
    """
    return path.suffix.lower() in (".jpg", ".jpeg", ".jpe", ".jfif", ".mpo", ".png")


def has_picture_ending(path: Path) -> bool:
    """Whether the name is that of a picture of any kind, also of one that may hold a film."""
    return is_named_as_picture(path) or path.suffix.lower() in OTHER_PICTURES


def jpeg_ends_early(content: bytes) -> bool:
    """Whether no end of image follows the first scan of a JPEG (ITU-T T.81, B.1.1)."""
    offset = 2
    while content[offset : offset + 1] == b"\xff" and content[offset + 1 : offset + 2] != b"\xda":
        offset += 2 + int.from_bytes(content[offset + 2 : offset + 4], "big")
    return b"\xff\xd9" not in content[offset:]


MAX_BOXES = 2**17
"""A film of 18 hours in fragments of a second has as many."""


def top_boxes(path: Path) -> Iterator[tuple[bytes, int, int]]:
    """The kind, offset and size in bytes of each outermost box, as far as they make sense."""
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
    """Whether the file starts as MP4 or MOV but was never given its "moov" box."""
    kinds = [kind for kind, _, _ in top_boxes(path)]
    return kinds[:1] in ([b"ftyp"], [b"wide"], [b"mdat"]) and b"moov" not in kinds


def ends_early(path: Path, formats: set[str]) -> bool:
    """Whether a file of one of FFmpeg's formats ends, or cannot be followed, before its structure does.

    Formats that do not tell where they end are taken for complete.
    """
    if "mp4" in formats:
        boxes = list(top_boxes(path))
        # Without fragments the index knows every frame, and what follows it does not matter.
        fragmented = len(boxes) < MAX_BOXES and any(kind == b"moof" for kind, _, _ in boxes)
        last, start, size = boxes[-1]
        return fragmented and not (last.isalnum() and start + size == path.stat().st_size)
    with path.open("rb") as file:
        try:
            return any(check(file) for name, check in _ENDS_EARLY.items() if name in formats)
        except (IndexError, struct.error):
            return True


def states_duration(path: Path) -> bool:
    """Whether a Matroska file has the duration in its header, which FFmpeg else estimates."""
    with path.open("rb") as file:
        return re.search(rb"\x44\x89[\x84\x88]", file.read(HEADER_BYTES)) is not None


def _matroska_ends_early(file: BinaryIO) -> bool:
    end = _segment_end(file.read(HEADER_BYTES))
    return end is not None and end > _size(file)


def _segment_end(head: bytes) -> int | None:
    """Where a Matroska file says that it ends; None: it is written as it comes (RFC 8794, section 6.2)."""
    before, identifier, after = head.partition(b"\x18\x53\x80\x67")
    if not after or not after[0]:
        return None
    length = 9 - after[0].bit_length()
    unknown = (1 << 7 * length) - 1
    segment = int.from_bytes(after[:length], "big") & unknown
    return None if segment == unknown else len(before + identifier) + length + segment


def _nut_ends_early(file: BinaryIO) -> bool:
    """The index is the last packet, and tells its length (NUT specification, file structure)."""
    size = _size(file)
    file.seek(size - 12)
    file.seek(max(0, size - int.from_bytes(file.read(8), "big")))
    return file.read(8) != b"NX\xdd\x67\x2f\x23\xe6\x4e"


def _avi_ends_early(file: BinaryIO) -> bool:
    (length,) = struct.unpack("<I", file.read(8)[4:])
    # It is -1 where the writer could not go back; some leave the byte out that makes it even.
    return length != 2**32 - 1 and length + 7 > _size(file)


def _gif_ends_early(file: BinaryIO) -> bool:
    """Follow the blocks to the trailer (GIF89a, section 15 and appendix A)."""

    def skip(count: int) -> None:
        file.seek(count, os.SEEK_CUR)

    def skip_colors(flags: int) -> None:
        skip(6 << (flags & 7) if flags & 0x80 else 0)

    skip_colors(file.read(13)[10])
    while (kind := file.read(1)) != b";":
        if kind == b",":
            skip_colors(file.read(9)[8:][0])
        elif kind != b"!":
            return True
        skip(1)
        while length := file.read(1):
            if length == b"\0":
                break
            skip(length[0])
    return False


def _ogg_ends_early(file: BinaryIO) -> bool:
    """The last page has the flag for the end of a stream (RFC 3533, section 6)."""
    file.seek(max(0, _size(file) - HEADER_BYTES))
    _, _, last = file.read().rpartition(b"OggS")
    return not (len(last) > 1 and last[1] & 4)


_ENDS_EARLY: dict[str, Callable[[BinaryIO], bool]] = {
    "matroska": _matroska_ends_early,
    "nut": _nut_ends_early,
    "avi": _avi_ends_early,
    "gif": _gif_ends_early,
    "ogg": _ogg_ends_early,
}


def _size(file: BinaryIO) -> int:
    return os.fstat(file.fileno()).st_size
