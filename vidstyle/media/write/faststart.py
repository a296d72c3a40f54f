"""Moves the index (moov box) of an MP4 file to the front, so that it plays while it loads.

FFmpeg rejects `faststart` together with `hybrid_fragmented`, whose files have the index last.
Boxes and offsets: ISO/IEC 14496-12.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import BinaryIO

from vidstyle.media.read.file_structure.headers import top_boxes

_PARENT_BOXES = (b"moov", b"trak", b"mdia", b"minf", b"stbl")
_MAX_INDEX_BYTES = 2**28


def move_index_first(source: Path, target: Path, surplus: Fraction = Fraction(0)) -> bool:
    """Write `source` to `target` with its index right after the file type box.

    Args:
        source, target: paths.
        surplus: seconds by which the last video sample is too long in the index.

    Returns:
        False, without writing, if the index is already first or the file has an unexpected structure.

    Raises:
        OSError: `target` cannot be written.
    """
    with source.open("rb") as file:
        boxes = list(top_boxes(source))
        names = [name for name, _, _ in boxes]
        if names.count(b"moov") != 1 or names[0] != b"ftyp" or names[-1] != b"moov":
            return False
        _, start, size = boxes[-1]
        file.seek(start)
        index = bytearray(file.read(size)) if size <= _MAX_INDEX_BYTES else bytearray()
        if not index or not _shift_offsets(index, 0, len(index), size):
            return False
        if surplus:
            _shorten_pictures(index, surplus)
        head = boxes[0][2]
        with target.open("wb") as out:
            _copy(file, out, 0, head)
            out.write(index)
            out.flush()
            _copy(file, out, head, start - head)
    return True


def _shift_offsets(index: bytearray, start: int, end: int, shift: int) -> bool:
    """Add `shift` to every chunk offset in place; return False if one overflows or a box is damaged."""
    for name, inside, after in _boxes(index, start, end):
        if after < inside or after > end:
            return False
        if name in _PARENT_BOXES and not _shift_offsets(index, inside, after, shift):
            return False
        if name in (b"stco", b"co64") and not _shift_table(index, inside, 4 if name == b"stco" else 8, shift):
            return False
    return True


def _shift_table(index: bytearray, start: int, width: int, shift: int) -> bool:
    count = int.from_bytes(index[start + 4 : start + 8], "big")
    code = f">{count}{'I' if width == 4 else 'Q'}"
    offsets = [offset + shift for offset in struct.unpack_from(code, index, start + 8)]
    if any(offset >= 256**width for offset in offsets):
        return False
    struct.pack_into(code, index, start + 8, *offsets)
    return True


def _shorten_pictures(index: bytearray, surplus: Fraction) -> None:
    """Subtract the surplus from the last video sample and from the duration of the track."""
    for name, start, end in _boxes(index, 8, len(index)):
        if name != b"trak" or index.find(b"vide", start, end) < 0:
            continue
        places = {name: (inside, after) for name, inside, after in _nested_boxes(index, start, end)}
        header = places[b"mdhd"][0]
        wide = index[header] == 1
        scale, width = header + (20 if wide else 12), 8 if wide else 4
        ticks = round(surplus * int.from_bytes(index[scale : scale + 4], "big"))
        length = _shorten_last(index, *places[b"stts"], ticks)
        index[scale + 4 : scale + 4 + width] = length.to_bytes(width, "big")


def _shorten_last(index: bytearray, start: int, end: int, ticks: int) -> int:
    """Shorten the last sample in a table of durations, if it has its own entry; return the total duration."""
    count, duration = struct.unpack_from(">II", index, end - 8)
    if count == 1 and duration > ticks:
        struct.pack_into(">I", index, end - 4, duration - ticks)
    table = struct.unpack_from(f">{(end - start - 8) // 4}I", index, start + 8)
    return sum(count * duration for count, duration in zip(table[::2], table[1::2], strict=True))


def _boxes(index: bytearray, start: int, end: int) -> Iterator[tuple[bytes, int, int]]:
    """Yield name, start and end of the content of each box in a range of the index."""
    while start + 8 <= end:
        size, name = struct.unpack_from(">I4s", index, start)
        yield name, start + 8, start + size
        start += size


def _nested_boxes(index: bytearray, start: int, end: int) -> Iterator[tuple[bytes, int, int]]:
    """Yield name, start and end of the content of all boxes, including nested ones."""
    for name, inside, after in _boxes(index, start, end):
        yield name, inside, after
        if name in _PARENT_BOXES:
            yield from _nested_boxes(index, inside, after)


def _copy(file: BinaryIO, out: BinaryIO, start: int, length: int) -> None:
    """Append a range of a file to another file, within the kernel if supported."""
    out.flush()
    while length:
        if hasattr(os, "copy_file_range"):
            done = os.copy_file_range(file.fileno(), out.fileno(), min(length, 2**30), start)
        else:
            file.seek(start)
            done = out.write(file.read(min(length, 2**22)))
        if not done:
            raise OSError(5, "the file ends early")
        start, length = start + done, length - done
