"""Tables in the index of an MP4 file that announce more entries than they hold, and their correction."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

ENTRY_BYTES = {b"stts": 8, b"ctts": 8, b"stsc": 12, b"stss": 4, b"stco": 4, b"co64": 8}
"""Tables of samples, and the bytes of an entry (ISO/IEC 14496-12, sections 8.6 and 8.7)."""
COUNT_OFFSET, TABLE_HEADER_BYTES = 12, 16
"""Where a table has its count, and where its entries begin."""
PARENTS = (b"moov", b"trak", b"mdia", b"minf", b"stbl", b"edts")
FIRST_BOXES = (b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip")
"""What an MP4 or MOV file begins with."""
MAX_BOXES = 2**12
"""Boxes of an index that are looked at; a film with a hundred tracks has as many."""


def cut_counts(path: Path) -> dict[int, bytes]:
    """The right count for each table that announces more entries than it holds, by its offset in the file."""
    with path.open("rb") as file:
        return dict(_cut_counts(file)) if file.read(8)[4:] in FIRST_BOXES else {}


def has_one_edit(path: Path) -> bool:
    """Whether each track shows one part of its samples, so that only the first and last may be hidden."""
    with path.open("rb") as file:
        # An empty edit may come before it.
        return all(
            _count(file, offset) <= 2 for kind, offset, _ in _boxes(file, 0, _size(file)) if kind == b"elst"
        )


class CorrectedFile:
    """A file in which some bytes read as others; does not tell its name."""

    def __init__(self, path: Path, corrections: dict[int, bytes]) -> None:
        self._file, self._corrections = path.open("rb"), corrections
        self.seek, self.tell, self.seekable = self._file.seek, self._file.tell, self._file.seekable

    def read(self, size: int) -> bytes:
        """As of a file."""
        start = self._file.tell()
        content = bytearray(self._file.read(size))
        for offset, correct in self._corrections.items():
            first, last = max(offset, start), min(offset + len(correct), start + len(content))
            if first < last:
                content[first - start : last - start] = correct[first - offset : last - offset]
        return bytes(content)

    def __del__(self) -> None:
        self._file.close()


def _cut_counts(file: BinaryIO) -> Iterator[tuple[int, bytes]]:
    for kind, offset, size in _boxes(file, 0, _size(file)):
        if kind in ENTRY_BYTES and size >= TABLE_HEADER_BYTES:
            room = (size - TABLE_HEADER_BYTES) // ENTRY_BYTES[kind]
            if _count(file, offset) > room:
                yield offset + COUNT_OFFSET, struct.pack(">I", room)


def _boxes(file: BinaryIO, start: int, end: int) -> Iterator[tuple[bytes, int, int]]:
    """The kind, offset and size of the boxes between two offsets, and of those in them, down to tables."""
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
        if kind in PARENTS:
            waiting.append((start + 8, start + size))


def _count(file: BinaryIO, offset: int) -> int:
    file.seek(offset + COUNT_OFFSET)
    return int.from_bytes(file.read(4))


def _size(file: BinaryIO) -> int:
    return os.fstat(file.fileno()).st_size
