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

from vidstyle.media.read.headers import top_boxes

_CONTAINERS = (b"moov", b"trak", b"mdia", b"minf", b"stbl")
_MAX_INDEX = 2**28


def move_index_first(source: Path, target: Path, surplus: Fraction = Fraction(0)) -> bool:
    """Write `source` to `target` with its index right after the file type box.

    Args:
        source, target: paths.
        surplus: seconds by which the last video sample is too long in the index.

    Returns:
        False, with nothing written, where the index is first already or the file is not laid out as expected.

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
        index = bytearray(file.read(size)) if size <= _MAX_INDEX else bytearray()
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
    """Add `shift` to every chunk offset in place; False if one does not fit, or a box is broken."""
    for name, inside, after in _inside(index, start, end):
        if after < inside or after > end:
            return False
        if name in _CONTAINERS and not _shift_offsets(index, inside, after, shift):
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
    for name, start, end in _inside(index, 8, len(index)):
        if name != b"trak" or index.find(b"vide", start, end) < 0:
            continue
        places = {name: (inside, after) for name, inside, after in _nested(index, start, end)}
        header = places[b"mdhd"][0]
        wide = index[header] == 1
        scale, width = header + (20 if wide else 12), 8 if wide else 4
        ticks = round(surplus * int.from_bytes(index[scale : scale + 4], "big"))
        length = _shorten_last(index, *places[b"stts"], ticks)
        index[scale + 4 : scale + 4 + width] = length.to_bytes(width, "big")


def _shorten_last(index: bytearray, start: int, end: int, ticks: int) -> int:
    """Shorten the last sample of a table of durations, if it stands alone; the sum of all durations."""
    count, duration = struct.unpack_from(">II", index, end - 8)
    if count == 1 and duration > ticks:
        struct.pack_into(">I", index, end - 4, duration - ticks)
    table = struct.unpack_from(f">{(end - start - 8) // 4}I", index, start + 8)
    return sum(count * duration for count, duration in zip(table[::2], table[1::2], strict=True))


def _inside(index: bytearray, start: int, end: int) -> Iterator[tuple[bytes, int, int]]:
    """Name, start and end of the content of each box of a part of the index."""
    while start + 8 <= end:
        size, name = struct.unpack_from(">I4s", index, start)
        yield name, start + 8, start + size
        start += size


def _nested(index: bytearray, start: int, end: int) -> Iterator[tuple[bytes, int, int]]:
    """The same, of the boxes in boxes too."""
    for name, inside, after in _inside(index, start, end):
        yield name, inside, after
        if name in _CONTAINERS:
            yield from _nested(index, inside, after)


def _copy(file: BinaryIO, out: BinaryIO, start: int, length: int) -> None:
    """Append part of a file to another, within the kernel where it can."""
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
