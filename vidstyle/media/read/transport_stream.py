"""Recordings whose MPEG-TS identifiers (PIDs) change midway: where, and their parts as files.

FFmpeg takes what follows for other streams, and PyAV drops the packets of streams that begin late.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

CHUNK_BYTES = 2**16
MAX_PARTS = 16
PACKET_BYTES = (188, 192, 204)
"""Sizes of a packet: bare, with a time stamp before it (M2TS), with a checksum behind it."""
SYNC = 0x47
UNIT_START, BARE = 0x40, 0x10
"""Bits of a packet's header: a table or a picture begins in it; nothing stands between header and content."""
PROGRAM_ASSOCIATION, PROGRAM_MAP = 0, 2
"""Identifiers of tables: of all programs, and of the streams of one."""
VIDEO_TYPES = frozenset({0x01, 0x02, 0x10, 0x1B, 0x20, 0x24, 0x33, 0x42, 0xD1, 0xD2, 0xEA})
"""Stream types of video (ISO/IEC 13818-1, table 2-34, and private ones)."""

Pids = frozenset[int]


def part_offsets(path: Path) -> list[int]:
    """Where the parts of a recording begin, in bytes: at 0, and wherever none of its video PIDs stays."""
    offsets, current = [0], Pids()
    with path.open("rb") as file:
        for offset, pids in _video_pids(file):
            if current and not pids & current:
                offsets.append(offset)
            current = pids
    return offsets[:MAX_PARTS]


class FilePart:
    """A part of a file, as a file that does not tell its name."""

    def __init__(self, path: Path, start: int, end: int) -> None:
        self._file, self._start, self._end = path.open("rb"), start, end
        self._file.seek(start)

    def read(self, size: int) -> bytes:
        """Up to `size` bytes; none at the end."""
        return self._file.read(max(0, min(size, self._end - self._file.tell())))

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """As of a file."""
        origin = {os.SEEK_SET: self._start, os.SEEK_CUR: self._file.tell(), os.SEEK_END: self._end}[whence]
        return self._file.seek(max(self._start, origin + offset)) - self._start

    def tell(self) -> int:
        """As of a file."""
        return self._file.tell() - self._start

    def seekable(self) -> bool:
        """As of a file."""
        return True

    def __del__(self) -> None:
        self._file.close()


def _video_pids(file: BinaryIO) -> Iterator[tuple[int, Pids]]:
    """All video PIDs after each program map, and where the tables before it begin."""
    programs: dict[int, Pids] = {}
    begin = 0
    for offset, packet in _table_packets(file):
        pid, table = int.from_bytes(packet[1:3]) & 0x1FFF, packet[5:]
        if pid == 0:
            begin, listed = offset, set(_program_pids(table))
            programs = {pid: videos for pid, videos in programs.items() if pid in listed}
        elif videos := Pids(_stream_pids(table)):
            programs[pid] = videos
            yield begin, Pids().union(*programs.values())


def _table_packets(file: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """The packets in which a table begins, and their offsets."""
    start, place, size = 0, 0, PACKET_BYTES[0]
    while True:
        file.seek(start)
        content = np.frombuffer(file.read(CHUNK_BYTES), np.uint8)
        if len(content) < PACKET_BYTES[-1]:
            return
        if not (content[place::size] == SYNC).all():
            place, size = _alignment(content)
        rows = content[place:][: (len(content) - place) // size * size].reshape(-1, size)
        is_table = (rows[:, 0] == SYNC) & ((rows[:, 1] & UNIT_START) > 0) & ((rows[:, 3] & 0x30) == BARE)
        is_table &= rows[:, 4] == 0
        is_association = ((rows[:, 1] & 0x1F) | rows[:, 2] | rows[:, 5]) == PROGRAM_ASSOCIATION
        for number in np.flatnonzero(is_table & (is_association | (rows[:, 5] == PROGRAM_MAP))):
            yield start + place + int(number) * size, rows[number].tobytes()
        start, place = start + place + rows.size, 0


def _alignment(content: np.ndarray) -> tuple[int, int]:
    """Where the first packet begins by most sync bytes, and the size of packets."""
    shares = {}
    for size in PACKET_BYTES:
        rows = content[: len(content) // size * size].reshape(-1, size)
        counts = (rows == SYNC).mean(axis=0)
        shares[int(counts.argmax()), size] = counts.max()
    return max(shares, key=lambda each: shares[each])


def _program_pids(table: bytes) -> Iterator[int]:
    """The PIDs of the program maps that an association lists."""
    end = 3 + (int.from_bytes(table[1:3]) & 0xFFF) - 4
    for offset in range(8, min(end, len(table) - 3), 4):
        yield int.from_bytes(table[offset + 2 : offset + 4]) & 0x1FFF


def _stream_pids(table: bytes) -> Iterator[int]:
    """The PIDs of video that a program map lists, as far as it lies in one packet."""
    end = 3 + (int.from_bytes(table[1:3]) & 0xFFF) - 4
    offset = 12 + (int.from_bytes(table[10:12]) & 0xFFF)
    while offset + 5 <= min(end, len(table)):
        if table[offset] in VIDEO_TYPES:
            yield int.from_bytes(table[offset + 1 : offset + 3]) & 0x1FFF
        offset += 5 + (int.from_bytes(table[offset + 3 : offset + 5]) & 0xFFF)
