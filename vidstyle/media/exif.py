"""Orientation of photographs: EXIF in the bytes of JPEG, PNG, WebP and TIFF pictures."""

from __future__ import annotations

import struct
from collections.abc import Iterator

from vidstyle.media.orientation import Orientation

ByteView = bytes | memoryview
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
TIFF_STARTS = (b"II*\0", b"MM\0*")
EXIF_PREFIX = b"Exif\0\0"
"""Prefix of the TIFF structure in JPEG, and in some WebP and PNG files."""
ORIENTATION_TAG_CODE, SHORT_TYPE_CODE = 0x0112, 3
"""Tag of the orientation, and the type of its value (EXIF 2.32, section 4.6.4)."""
START_OF_SCAN_CODE = 0xDA


def exif_orientation(content: ByteView) -> Orientation | None:
    r"""Return the orientation in the EXIF of a complete picture file; None if there is none.

    >>> exif_orientation(b"II*\0" + struct.pack("<IHHHIHH", 8, 1, 0x0112, 3, 1, 6, 0))
    Orientation(transpose=True, mirror_x=True, mirror_y=False)
    """
    exif = next(_exif_blocks(content), b"")
    exif = exif[len(EXIF_PREFIX) :] if exif[: len(EXIF_PREFIX)] == EXIF_PREFIX else exif
    try:
        number = _first_orientation(exif)
    except struct.error:  # cut off
        return None
    return Orientation.from_exif(number) if 1 <= number <= 8 else None


def hide_png_exif(content: bytes) -> bytes:
    r"""Rename the EXIF chunk of a PNG: FFmpeg rejects pictures whose EXIF is damaged.

    >>> hide_png_exif(PNG_SIGNATURE + bytes(4) + b"eXIf")[8:]
    b'\x00\x00\x00\x00xxIf'
    """
    hidden, offset = bytearray(content), len(PNG_SIGNATURE)
    for name, data in png_chunks(content):
        if name == b"eXIf":
            hidden[offset + 4 : offset + 8] = b"xxIf"
        offset += len(data) + 12
    return bytes(hidden)


def png_chunks(content: ByteView) -> Iterator[tuple[bytes, ByteView]]:
    """Yield the name and data of each chunk of a PNG (ISO/IEC 15948, section 5.3)."""
    offset = len(PNG_SIGNATURE)
    while offset + 8 <= len(content):
        (size,) = struct.unpack_from(">I", content, offset)
        yield bytes(content[offset + 4 : offset + 8]), content[offset + 8 : offset + 8 + size]
        offset += size + 12


def _exif_blocks(content: ByteView) -> Iterator[ByteView]:
    """Yield the TIFF structures with the EXIF tags of the first image of a file."""
    if content[:4] in TIFF_STARTS:
        yield content
    elif content[:3] == b"\xff\xd8\xff":
        yield from (part for part in _jpeg_segments(content, 0xE1) if part[: len(EXIF_PREFIX)] == EXIF_PREFIX)
    elif content[: len(PNG_SIGNATURE)] == PNG_SIGNATURE:
        yield from (data for name, data in png_chunks(content) if name == b"eXIf")
    elif content[:4] == b"RIFF" and content[8:12] == b"WEBP":
        yield from _riff_chunks(content, b"EXIF")


def _jpeg_segments(content: ByteView, wanted: int) -> Iterator[ByteView]:
    """Yield the data of the segments with a marker before the first scan (ITU-T T.81, B.1.1)."""
    offset = 2
    while (
        offset + 4 <= len(content) and content[offset] == 0xFF and content[offset + 1] != START_OF_SCAN_CODE
    ):
        marker, size = struct.unpack_from(">xBH", content, offset)
        if marker == wanted:
            yield content[offset + 4 : offset + 2 + size]
        offset += 2 + size


def _riff_chunks(content: ByteView, wanted: bytes) -> Iterator[ByteView]:
    """Yield the data of the chunks of a name in a WebP (RFC 9649, section 2.3)."""
    offset = 12
    while offset + 8 <= len(content):
        name, size = struct.unpack_from("<4sI", content, offset)
        if name == wanted:
            yield content[offset + 8 : offset + 8 + size]
        offset += 8 + size + size % 2


def _first_orientation(tiff: ByteView) -> int:
    """Return the value of the first orientation tag, 0 if there is none; raise struct.error if truncated."""
    if tiff[:4] not in TIFF_STARTS:
        return 0
    order = "<" if tiff[:1] == b"I" else ">"
    (offset,) = struct.unpack_from(order + "I", tiff, 4)
    (entries,) = struct.unpack_from(order + "H", tiff, offset)
    for number in range(entries):
        tag, kind, _, value = struct.unpack_from(order + "HHIH", tiff, offset + 2 + 12 * number)
        if (tag, kind) == (ORIENTATION_TAG_CODE, SHORT_TYPE_CODE):
            return int(value)
    return 0
