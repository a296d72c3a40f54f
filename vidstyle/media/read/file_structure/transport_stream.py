"""Recordings whose MPEG-TS identifiers (PIDs) or codecs change in mid-file: find them and read their parts.

FFmpeg treats the data after a change as new streams, and PyAV drops the packets of streams that start late.
If only the codec changes, FFmpeg decodes one of the two. The data after a change is read as another part. For
sound that starts late, the tables show which streams are lost.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import BinaryIO

import numpy as np

CHUNK_BYTES = 2**16
HEAD_BYTES = 1024
"""Enough to tell a transport stream from other formats."""
MAX_PARTS = 16
MAX_TABLES = 1024
"""Size of the cache of checked tables: a recording repeats the same ones ten times per second."""
PACKET_BYTES = (188, 192, 204)
"""Sizes of a packet: plain, with a preceding timestamp (M2TS), with a trailing checksum."""
SYNC_BYTE = 0x47
UNIT_START_BIT, PAYLOAD_ONLY_BITS = 0x40, 0x10
"""Bits of a packet's header: a table or a picture starts in it; its header has no adaptation field."""
PROGRAM_ASSOCIATION_ID, PROGRAM_MAP_ID = 0, 2
"""Identifiers of tables: list of all programs, and list of the streams of a program."""
VIDEO_TYPES = frozenset({0x01, 0x02, 0x10, 0x1B, 0x20, 0x24, 0x33, 0x42, 0xD1, 0xD2, 0xEA})
"""Stream types of video (ISO/IEC 13818-1, table 2-34, and private types)."""

AUDIO_TYPES = frozenset({0x03, 0x04, 0x0F, 0x11, 0x1C, 0x80, 0x81, 0x82, 0x83, 0x84, 0x85, 0x87})
"""Stream types of audio; private streams (0x06) need descriptors, which are not parsed."""
CRC_POLYNOMIAL = 0x04C11DB7
"""Polynomial of the checksum of a table (ISO/IEC 13818-1, annex A)."""

Streams = frozenset[tuple[int, int]]
"""PID and stream type of each stream."""


@dataclass
class RecordingPart:
    """A part of a recording.

    Attributes:
        start: offset in bytes.
        pids: PIDs of video and audio in its tables.
        successors: audio PIDs, each with the PID that it replaces in the tables.
    """

    start: int = 0
    pids: set[int] = field(default_factory=set)
    successors: dict[int, int] = field(default_factory=dict)
    _programs: dict[int, Streams] = field(default_factory=dict)

    def add(self, program: int, streams: Streams) -> None:
        """Add the video and audio streams of a program."""
        before = self._programs.get(program, streams)
        new = [each for each in streams if each[0] not in self.pids]
        for gone, kind in sorted(before - streams):
            if kind in AUDIO_TYPES and (match := next((pid for pid, other in new if other == kind), None)):
                self.successors[match] = self.successors.get(gone, gone)
                new.remove((match, kind))
        self._programs[program] = streams
        self.pids |= {pid for pid, _ in streams}


class Recording:
    """A recording whose content arrives in pieces, and the parts that its tables define.

    Attributes:
        parts: one begins at 0, and another at each point at which no video continues.
        decided: the offset up to which the beginnings of parts are known.
    """

    def __init__(self) -> None:
        self.parts, self.decided, self._videos = [RecordingPart()], 0, Streams()
        self._programs: dict[int, Streams] = {}
        self._rest, self._packet_bytes = b"", PACKET_BYTES[0]

    def add(self, content: bytes) -> None:
        """Take the next content."""
        for offset, packet in self._table_packets(content):
            pid, table = int.from_bytes(packet[1:3]) & 0x1FFF, packet[5:]
            if _is_damaged(table):
                continue
            if pid == 0:
                listed = set(_program_pids(table))
                self._programs = {pid: videos for pid, videos in self._programs.items() if pid in listed}
            else:
                self._add_program(offset, pid, Streams(_streams(table)))

    def _add_program(self, offset: int, program: int, listed: Streams) -> None:
        """Take the streams of a program; a program without video begins no part."""
        streams = Streams(each for each in listed if each[1] in VIDEO_TYPES | AUDIO_TYPES)
        if not (videos := Streams(each for each in streams if each[1] in VIDEO_TYPES)):
            return
        self._programs[program] = videos
        current = Streams().union(*self._programs.values())
        if self._videos and not current & self._videos and len(self.parts) < MAX_PARTS:
            self.parts.append(RecordingPart(offset))
        self._videos = current
        self.parts[-1].add(program, streams)

    def _table_packets(self, content: bytes) -> Iterator[tuple[int, bytes]]:
        """Yield the packets in which a table begins, with their offsets."""
        seen = np.frombuffer(self._rest + content, np.uint8)
        if len(seen) < PACKET_BYTES[-1]:
            self._rest = seen.tobytes()
            return
        starts, start = self._packet_starts(seen), self.decided
        used = int(starts[-1]) + self._packet_bytes if len(starts) else len(seen) - PACKET_BYTES[-1]
        self._rest = seen[used:].tobytes()
        self.decided += used
        is_table = ((seen[starts + 1] & UNIT_START_BIT) > 0) & (
            (seen[starts + 3] & 0x30) == PAYLOAD_ONLY_BITS
        )
        is_table &= seen[starts + 4] == 0
        is_association = (
            (seen[starts + 1] & 0x1F) | seen[starts + 2] | seen[starts + 5]
        ) == PROGRAM_ASSOCIATION_ID
        for place in starts[is_table & (is_association | (seen[starts + 5] == PROGRAM_MAP_ID))]:
            yield start + int(place), seen[place : place + self._packet_bytes].tobytes()

    def _packet_starts(self, seen: np.ndarray) -> np.ndarray:
        """Return the offsets of the complete packets; bytes may be missing or added between them."""
        if (seen[:: self._packet_bytes] == SYNC_BYTE).all():
            return np.arange(0, len(seen) - self._packet_bytes + 1, self._packet_bytes)
        _, size = _alignment(seen)
        self._packet_bytes = size
        is_sync = seen == SYNC_BYTE
        has_neighbor = np.zeros_like(is_sync)
        has_neighbor[:-size] = is_sync[size:]
        has_neighbor[size:] |= is_sync[:-size]
        return np.flatnonzero((is_sync & has_neighbor)[: len(seen) - size + 1])


def find_recording_parts(path: Path) -> list[RecordingPart]:
    """Return the parts of a recording in a file."""
    recording = Recording()
    with path.open("rb") as file:
        while content := file.read(CHUNK_BYTES):
            recording.add(content)
    return recording.parts


class RecordingStream:
    """A streamed recording, as a file that ends at the end of its current part."""

    def __init__(self, file: BinaryIO, head: bytes) -> None:
        """Begin with the first part.

        Args:
            file: the stream.
            head: bytes that were already read from it.
        """
        self._file, self._recording, self._number = file, Recording(), 0
        self._waiting, self._offset, self._has_ended = bytearray(head), 0, False
        self._recording.add(head)

    @property
    def part(self) -> RecordingPart:
        """The current part, according to the tables read so far."""
        return self._recording.parts[self._number]

    def read(self, size: int) -> bytes:
        """Return up to `size` bytes of the current part; none at its end."""
        while (count := min(size, self._end() - self._offset)) <= 0 and not self._is_over():
            content = self._file.read(size)
            self._has_ended = not content
            self._recording.add(content)
            self._waiting += content
        content = bytes(self._waiting[: max(0, count)])
        del self._waiting[: len(content)]
        self._offset += len(content)
        return content

    def enter_next_part(self) -> bool:
        """Skip the rest of the current part; return whether another one follows."""
        while self.read(CHUNK_BYTES):
            pass
        has_next = len(self._recording.parts) > self._number + 1
        self._number += has_next
        return has_next

    def _is_over(self) -> bool:
        """Whether the current part is complete."""
        return self._has_ended or len(self._recording.parts) > self._number + 1

    def _end(self) -> int:
        """Return the offset up to which content certainly belongs to the current part."""
        later = self._recording.parts[self._number + 1 :]
        if later:
            return later[0].start
        return self._offset + len(self._waiting) if self._has_ended else self._recording.decided


def opened_stream(file: BinaryIO) -> BinaryIO | RecordingStream | ReplayedStream:
    """Return the file to read instead of a stream; its first bytes show its format."""
    head = file.read(HEAD_BYTES)
    if _is_recording(head):
        return RecordingStream(file, head)
    if not file.seekable():
        return ReplayedStream(file, head)
    file.seek(-len(head), os.SEEK_CUR)
    return file


class ReplayedStream:
    """A stream whose first bytes have already been read."""

    def __init__(self, file: BinaryIO, head: bytes) -> None:
        self._file, self._head = file, head

    def read(self, size: int) -> bytes:
        """Return up to `size` bytes, as a file does."""
        content, self._head = self._head[:size], self._head[size:]
        return content or self._file.read(size)


def _is_recording(head: bytes) -> bool:
    content = np.frombuffer(head, np.uint8)
    if len(content) < HEAD_BYTES:
        return False
    place, size = _alignment(content)
    return bool((content[place::size] == SYNC_BYTE).all())


class FilePart:
    """A part of a file, as a file without a name for FFmpeg."""

    def __init__(self, path: Path, start: int, end: int) -> None:
        self._file, self._start, self._end = path.open("rb"), start, end
        self._file.seek(start)

    def read(self, size: int) -> bytes:
        """Read up to `size` bytes; none at the end."""
        return self._file.read(max(0, min(size, self._end - self._file.tell())))

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Seek as in a file."""
        origin = {os.SEEK_SET: self._start, os.SEEK_CUR: self._file.tell(), os.SEEK_END: self._end}[whence]
        return self._file.seek(max(self._start, origin + offset)) - self._start

    def tell(self) -> int:
        """Return the position in the part."""
        return self._file.tell() - self._start

    def seekable(self) -> bool:
        """Return True."""
        return True

    def __del__(self) -> None:
        self._file.close()


@lru_cache(MAX_TABLES)
def _is_damaged(table: bytes) -> bool:
    """Whether the checksum of a table is wrong; tables in several packets are not checked."""
    end = 3 + (int.from_bytes(table[1:3]) & 0xFFF)
    checksum = 2**32 - 1
    for byte in table[:end] if end <= len(table) else b"":
        checksum ^= byte << 24
        for _ in range(8):
            checksum = (checksum << 1) ^ (CRC_POLYNOMIAL if checksum >> 31 else 0)
            checksum &= 2**32 - 1
    return end <= len(table) and checksum != 0


def _alignment(content: np.ndarray) -> tuple[int, int]:
    """Return the offset of the first packet, by most sync bytes, and the packet size."""
    shares = {}
    for size in PACKET_BYTES:
        rows = content[: len(content) // size * size].reshape(-1, size)
        counts = (rows == SYNC_BYTE).mean(axis=0)
        shares[int(counts.argmax()), size] = counts.max()
    return max(shares, key=lambda each: shares[each])


def _program_pids(table: bytes) -> Iterator[int]:
    """Yield the PIDs of the program maps in an association table."""
    end = 3 + (int.from_bytes(table[1:3]) & 0xFFF) - 4
    for offset in range(8, min(end, len(table) - 3), 4):
        yield int.from_bytes(table[offset + 2 : offset + 4]) & 0x1FFF


def _streams(table: bytes) -> Iterator[tuple[int, int]]:
    """Yield PID and type of the streams in the first packet of a program map."""
    end = 3 + (int.from_bytes(table[1:3]) & 0xFFF) - 4
    offset = 12 + (int.from_bytes(table[10:12]) & 0xFFF)
    while offset + 5 <= min(end, len(table)):
        yield int.from_bytes(table[offset + 1 : offset + 3]) & 0x1FFF, table[offset]
        offset += 5 + (int.from_bytes(table[offset + 3 : offset + 5]) & 0xFFF)
