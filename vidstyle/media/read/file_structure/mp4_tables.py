"""Correction of tables in the index of an MP4 file that occur twice or list too many entries."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import BinaryIO

ENTRY_BYTES = {b"stts": 8, b"ctts": 8, b"stsc": 12, b"stss": 4, b"stco": 4, b"co64": 8}
"""Sample tables, and the bytes of an entry (ISO/IEC 14496-12, sections 8.6 and 8.7)."""
TYPE_OFFSET_BYTES, COUNT_OFFSET_BYTES, TABLE_HEADER_BYTES = 4, 12, 16
"""Offsets in a table: of its type, of its count and of its entries."""
HEADER_FORMATS = {b"tkhd": (">8xII", ">16xII"), b"mdhd": (">8xII", ">16xIQ")}
"""Formats of headers, versions 0 and 1: identifier of a track; ticks per second and duration of its media."""
MAX_HEADER_BYTES = 32
PARENT_BOXES = (b"moov", b"trak", b"mdia", b"minf", b"stbl", b"edts")
FIRST_BOXES = (b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip")
"""Types of the first box of an MP4 or MOV file."""
MAX_BOXES = 2**12
"""Maximum number of boxes of an index to read; a film with a hundred tracks has this many."""


def find_corrections(path: Path) -> dict[int, bytes]:
    """Return the bytes that correct the tables of a file, by their offset in the file."""
    with path.open("rb") as file:
        return dict(_corrections(file)) if file.read(8)[4:] in FIRST_BOXES else {}


def has_one_edit(path: Path) -> bool:
    """Whether each track shows one range of its samples, so that only the first and last may be hidden."""
    with path.open("rb") as file:
        # An empty edit may precede it.
        return all(
            _count(file, offset) <= 2 for kind, offset, _ in _boxes(file, 0, _size(file)) if kind == b"elst"
        )


def track_seconds(path: Path, track: int) -> Fraction:
    """Return the duration of a track including hidden samples, by the track's identifier; 0 if unknown."""
    current = 0
    with path.open("rb") as file:
        for kind, offset, _ in _boxes(file, 0, _size(file)):
            if kind in HEADER_FORMATS:
                file.seek(offset + TYPE_OFFSET_BYTES + 4)
                header = file.read(MAX_HEADER_BYTES).ljust(MAX_HEADER_BYTES)
                # Version 1 has times and durations of 64 bits.
                first, second = struct.unpack_from(HEADER_FORMATS[kind][header[0] == 1], header, 4)
                if kind == b"tkhd":
                    current = first
                elif current == track and first:
                    return Fraction(second, first)
    return Fraction(0)


class CorrectedFile:
    """A file with some bytes replaced, and without a name for FFmpeg."""

    def __init__(self, path: Path, corrected: dict[int, bytes]) -> None:
        self._file, self._corrections = path.open("rb"), corrected
        self.seek, self.tell, self.seekable = self._file.seek, self._file.tell, self._file.seekable

    def read(self, size: int) -> bytes:
        """Read as from a file."""
        start = self._file.tell()
        content = bytearray(self._file.read(size))
        for offset, correct in self._corrections.items():
            first, last = max(offset, start), min(offset + len(correct), start + len(content))
            if first < last:
                content[first - start : last - start] = correct[first - offset : last - offset]
        return bytes(content)

    def __del__(self) -> None:
        self._file.close()


def _corrections(file: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Yield the right count of tables with too many entries, and another type for a second duration table."""
    has_durations = False
    for kind, offset, size in _boxes(file, 0, _size(file)):
        if kind == b"stts" and has_durations:  # FFmpeg rejects the file
            yield offset + TYPE_OFFSET_BYTES, b"free"
        has_durations = kind == b"stts" or (has_durations and kind != b"stbl")
        if kind in ENTRY_BYTES and size >= TABLE_HEADER_BYTES:
            room = (size - TABLE_HEADER_BYTES) // ENTRY_BYTES[kind]
            if _count(file, offset) > room:
                yield offset + COUNT_OFFSET_BYTES, struct.pack(">I", room)


def _boxes(file: BinaryIO, start: int, end: int) -> Iterator[tuple[bytes, int, int]]:
    """Yield type, offset and size of the boxes between two offsets, including nested boxes."""
    waiting, seen = [(start, end)], 0
    while waiting and seen < MAX_BOXES:
        start, end = waiting.pop()
        seen += 1
        if end - start < 8:
            continue
        file.seek(start)
        header = file.read(16)
        size, kind = int.from_bytes(header[:4]), header[4:8]
        size = {0: end - start, 1: int.from_bytes(header[8:16])}.get(size, size)
        if not 8 <= size <= end - start:
            continue
        yield kind, start, size
        waiting.append((start + size, end))
        if kind in PARENT_BOXES:
            waiting.append((start + 8, start + size))


def _count(file: BinaryIO, offset: int) -> int:
    file.seek(offset + COUNT_OFFSET_BYTES)
    return int.from_bytes(file.read(4))


def _size(file: BinaryIO) -> int:
    return os.fstat(file.fileno()).st_size
