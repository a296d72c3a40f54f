"""Syntax of the formats whose structure is changed."""

from __future__ import annotations

import struct
import zlib

from tools.fuzzing.structure import Extent, Family, Order, Part, Syntax


def _box(content: bytes, place: int) -> Extent | None:
    head = content[place : place + 16]
    size, begin = int.from_bytes(head[:4]), 8
    if size == 1:
        size, begin = int.from_bytes(head[8:]), 16
    after = place + size if size else len(content)
    return Extent(head[4:8], place + begin, after, after) if after - place >= begin else None


def _vint_length(first: int) -> int:
    return 9 - first.bit_length()


def _element(content: bytes, place: int) -> Extent | None:
    begin = place + _vint_length(content[place])
    if not place < begin < len(content):
        return None
    length = _vint_length(content[begin])
    size = int.from_bytes(content[begin : begin + length]) & (1 << 7 * length) - 1
    is_unknown = size == (1 << 7 * length) - 1
    after = len(content) if is_unknown else begin + length + size
    return Extent(content[place:begin], begin + length, after, after) if length < 9 else None


def _riff_chunk(content: bytes, place: int) -> Extent:
    end = place + 8 + int.from_bytes(content[place + 4 : place + 8], "little")
    return Extent(content[place : place + 4], place + 8, end, min(end + end % 2, max(end, len(content))))


def _png_chunk(content: bytes, place: int) -> Extent:
    end = place + 8 + int.from_bytes(content[place : place + 4])
    return Extent(content[place + 4 : place + 8], place + 8, end, end + 4)


def _flv_tag(content: bytes, place: int) -> Extent:
    end = place + 11 + int.from_bytes(content[place + 1 : place + 4])
    return Extent(content[place : place + 1], place + 4, end, end + 4)


def _segment(content: bytes, place: int) -> Extent | None:
    if content[place] != 0xFF or place + 4 > len(content):
        return None
    end = place + 2 + int.from_bytes(content[place + 2 : place + 4])
    return Extent(content[place : place + 2], place + 4, end, end)


def _packet(content: bytes, place: int) -> Extent:
    return Extent(content[place : place + 1], place + 1, place + 188, place + 188)


def _number(size: int, width: int, order: Order = "big") -> bytes:
    return (size % 256**width).to_bytes(width, order)


FOUR_LETTERS = "moov trak mdia minf stbl edts udta dinf ilst iprp ipco moof traf mvex"
BOXES = Family(
    _box,
    lambda name, size: _number(size + 8, 4) + name,
    containers={name.encode(): 0 for name in FOUR_LETTERS.split()} | {b"meta": 4, b"stsd": 8, b"dref": 8},
)
ELEMENTS = Family(
    _element,
    lambda name, size: name + _number(size | 1 << 56, 8),
    # Segment, SeekHead, Info, Tracks, TrackEntry, Video, Audio, Cluster, BlockGroup, Cues, CuePoint, Tags.
    containers=dict.fromkeys(
        map(
            bytes.fromhex,
            "18538067 114d9b74 1549a966 1654ae6b ae e0 e1 1f43b675 a0 1c53bb6b bb 1254c367 7373".split(),
        ),
        0,
    ),
)
RIFF = Family(
    _riff_chunk,
    lambda name, size: name + _number(size, 4, "little"),
    lambda head, content: bytes(len(content) % 2),
    {b"RIFF": 4, b"LIST": 4},
    order="little",
)
PNG_CHUNKS = Family(
    _png_chunk,
    lambda name, size: _number(size, 4) + name,
    lambda head, content: _number(zlib.crc32(head[4:] + content), 4),
    signature=8,
)
FLV_TAGS = Family(
    _flv_tag,
    lambda name, size: name + _number(size - 7, 3),
    lambda head, content: _number(len(head + content), 4),
    signature=13,
)
SEGMENTS = Family(_segment, lambda name, size: name + _number(size + 2, 2), signature=2)
PACKETS = Family(_packet, lambda name, size: name)


class TiffTags:
    """The tags of the first page of a TIFF file; changed tags are appended to the file."""

    order: Order = "little"

    def read(self, content: bytes) -> list[Part]:
        """Return the bytes of the full file, the tags, and the offset of the next page."""
        order = "<" if content[:2] == b"II" else ">"
        (start,) = struct.unpack_from(f"{order}I", content, 4)
        (count,) = struct.unpack_from(f"{order}H", content, start)
        tags = [content[place : place + 12] for place in range(start + 2, start + 2 + 12 * count, 12)]
        following = content[start + 2 + 12 * count :][:4]
        return [Part(b"", content), *(Part(tag[:2], tag[2:]) for tag in tags), Part(b"", following)]

    def write(self, parts: list[Part]) -> bytes:
        """Return the file with the tags appended and their offset in the header updated."""
        texts = [part.name + part.content for part in parts]
        body = max(texts, key=len, default=b"")
        order = "<" if body[:2] == b"II" else ">"
        tags = [text for text in texts if len(text) == 12]
        count = struct.pack(f"{order}H", len(tags))
        following = next((text for text in texts if len(text) == 4), bytes(4))
        body += bytes(len(body) % 2)
        offset = struct.pack(f"{order}I", len(body))
        return body[:4] + offset + body[8:] + count + b"".join(tags) + following


FAMILIES: dict[str, Syntax] = {
    **dict.fromkeys((".mp4", ".mov", ".avif"), BOXES),
    **dict.fromkeys((".mkv", ".webm"), ELEMENTS),
    **dict.fromkeys((".avi", ".webp"), RIFF),
    ".png": PNG_CHUNKS,
    ".jpg": SEGMENTS,
    ".tif": TiffTags(),
    ".ts": PACKETS,
    ".flv": FLV_TAGS,
}
"""Syntax by file ending."""
