"""Facts from file headers that FFmpeg does not give before decoding: sizes, EXIF orientation, MP4 boxes."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from pathlib import Path

HEADER_BYTES = 2**18
"""Bytes at the start of a file that contain the size of the picture and its EXIF tags."""
EXIF_ORIENTATION = 0x0112


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


def exif_orientation(head: bytes) -> int:
    """The EXIF orientation, 1 to 8, of a JPEG; 1, upright, where it has none (EXIF 2.32, section 4.6.4)."""
    found = re.search(rb"Exif\0\0(II\*\0|MM\0\*)", head) if is_jpeg(head) else None
    if found is None:
        return 1
    tiff = head[found.start(1) :]
    order = "<" if tiff[:2] == b"II" else ">"
    try:
        (offset,) = struct.unpack_from(order + "I", tiff, 4)
        (entries,) = struct.unpack_from(order + "H", tiff, offset)
        for number in range(entries):
            tag, _, _, value = struct.unpack_from(order + "HHIH", tiff, offset + 2 + 12 * number)
            if tag == EXIF_ORIENTATION:
                return value if 1 <= value <= 8 else 1
    except struct.error:
        pass
    return 1


MAX_BOXES = 10_000


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
            if size < 8:
                return
            offset += size


def has_no_index(path: Path) -> bool:
    """Whether the file starts as MP4 or MOV but was never given its "moov" box."""
    kinds = [kind for kind, _, _ in top_boxes(path)]
    return kinds[:1] in ([b"ftyp"], [b"wide"], [b"mdat"]) and b"moov" not in kinds
