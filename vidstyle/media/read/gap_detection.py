"""Detect missing data: gaps that cannot be read, and frames and duration that only the header has."""

from __future__ import annotations

import os
from collections import Counter
from fractions import Fraction
from pathlib import Path
from typing import BinaryIO

import av

from vidstyle.media.read.decode_report import DURATION_TOLERANCE_SECONDS, DecodeReport
from vidstyle.media.read.file_structure.headers import (
    FLV_SOUND_ID,
    FLV_VIDEO_ID,
    ends_early,
    flv_codecs,
    is_followed,
    states_duration,
)
from vidstyle.media.read.file_structure.mp4_tables import find_corrections, has_one_edit, track_seconds

CONTIGUOUS_FORMATS = frozenset({"matroska", "webm", "flv", "nut", "avi"})
"""Formats that contain little except packets between the first packet and the last."""
MAX_BETWEEN_PACKETS_BYTES = 1024
"""Maximum number of bytes between two packets of such a format."""
MAX_REORDERED_FRAMES = 16
"""Maximum number of frames that codecs reorder; hidden frames this near to an end are normal."""
MAX_GAP_DISTANCE = 8
"""Maximum distance in packets from a corrupt packet to its gap: demuxers set the flag early."""


BLOCK_IDS = (b"\xa3", b"\xa1")
PARENT_IDS = (b"\xa0", b"\x1f\x43\xb6\x75")
"""Identifiers of Matroska elements (RFC 9559): blocks; block groups and clusters, which contain blocks."""
ELEMENT_HEADER_BYTES = 12
"""Maximum size of the header of an element."""
MIN_ID_BYTE = 0x10
"""Minimum first byte of the identifier of an element, which has one to four bytes."""
MAX_ELEMENTS = 2**17
"""Maximum number of elements to read after the last frame."""


class GapFinder:
    """Detects data that could not be read between packets: gaps in the file, and packets flagged corrupt."""

    def __init__(self, formats: set[str], reads_all: bool) -> None:
        """Start before the first packet.

        Args:
            formats: FFmpeg's names of the container's format.
            reads_all: whether every packet of the file is inspected.
        """
        self._shows_holes = reads_all and bool(formats & CONTIGUOUS_FORMATS)
        self._position = self._end = 0
        self._suspects = 0

    def inspect(self, packet: av.Packet) -> None:
        """Inspect the next packet of the file."""
        if packet.is_corrupt:
            self._suspects = MAX_GAP_DISTANCE
        if packet.pos is None:
            return
        if self._shows_holes and packet.pos > self._end + MAX_BETWEEN_PACKETS_BYTES and self._end:
            self.suspect()
        # Packets of one block share its position.
        start = self._end if packet.pos == self._position else packet.pos
        self._position, self._end = packet.pos, max(self._end, start + packet.size)

    def suspect(self) -> None:
        """Record that data before the next packet could not be read."""
        self._suspects = max(1, self._suspects)

    def forget(self) -> None:
        """Ignore gaps so far."""
        self._suspects = 0

    def before_picture(self) -> bool:
        """Whether there may be a gap before the latest packet, a video packet; call it once per packet."""
        found = self._suspects > 0
        self._suspects -= found
        return found


class HeaderCheck:
    """Compares the packets of a film with the header of its container.

    Attributes:
        packets: number of video packets so far.
    """

    def __init__(
        self,
        container: av.container.InputContainer,
        stream: av.video.stream.VideoStream,
        formats: set[str],
        file: Path | None,
    ) -> None:
        self._container, self._stream, self._formats, self._file = container, stream, formats, file
        self.packets = self._hidden = self._shown = 0
        self._hidden_after: list[int] = []
        self._position: int | None = None
        self._bounds = Fraction(0), Fraction(0)
        self._end = self._start = self._longest = Fraction(0)
        self._announced = self._announced_frames()

    def count(self, packet: av.Packet) -> None:
        """Count a packet of any stream."""
        if packet.pts is not None:
            self._end = max(self._end, (packet.pts + (packet.duration or 0)) * packet.time_base)
        if packet.stream_index != self._stream.index:
            return
        if packet.dts is not None:
            start = packet.dts * packet.time_base
            self._longest = max(self._longest, start - self._start) if self.packets else Fraction(0)
            self._start = start
        self.packets += 1
        self._position = packet.pos
        if packet.pts is not None:
            shown = packet.pts * packet.time_base
            self._bounds = min(shown, self._bounds[0]), max(shown, self._bounds[1])
        if packet.is_discard:
            self._hidden += 1
            self._hidden_after.append(self._shown)
        else:
            self._shown += 1

    def _unread_blocks(self) -> int:
        """Count the frames after the last packet of a Matroska file: FFmpeg may stop at damaged sound."""
        if self._file is None or "matroska" not in self._formats or self._position is None:
            return 0
        with self._file.open("rb") as file:
            return _count_blocks_after(file, self._position)

    def _unread_tags(self) -> int:
        """How many packets of an FLV file are of codecs that begin late: PyAV drops those streams."""
        if self._file is None or "flv" not in self._formats:
            return 0
        counts = flv_codecs(self._file).items()
        known = Counter(stream.type for stream in self._container.streams)
        sounds = [count for (kind, _), count in counts if kind == FLV_SOUND_ID]
        videos = [count for (kind, _), count in counts if kind == FLV_VIDEO_ID]
        return sum(sounds[known["audio"] :]) + sum(videos[known["video"] :])

    def shows_cut(self) -> bool:
        """Whether the file is truncated, by its index and its structure, without reading frames."""
        if self._file is None:
            return False
        size = self._file.stat().st_size
        indexed = self._stream.index_entries if "mp4" in self._formats else ()
        return any(each.pos + each.size > size for each in indexed) or ends_early(self._file, self._formats)

    def compare(self, damage: DecodeReport) -> None:
        """Report missing data: reading a truncated file ends without an error, only its header shows it."""
        if self._file is not None:
            damage.cut_off |= ends_early(self._file, self._formats)
            damage.is_followed |= is_followed(self._file, self._formats)
            damage.unmatched_packets += self._unread_tags()
        if self._has_bad_index():
            damage.has_bad_index = True
        elif self.packets < self._announced:
            # Every frame that is not delivered is missing, including the frame of a truncated packet.
            damage.missing_frames = self._announced - self._hidden - damage.decoded - damage.repeated
            damage.lost = 0
        elif unread := self._unread_blocks():
            damage.missing_frames += unread
        elif not damage.clock_jumps and (announced := self._announced_seconds(damage.cut_off)):
            # If frames have long durations, the last one may have one, too.
            if announced - self._end > max(DURATION_TOLERANCE_SECONDS, announced / 100, self._longest):
                damage.missing_seconds = announced - self._end
                damage.header_seconds = announced

    def _has_bad_index(self) -> bool:
        """Whether the index of an MP4 file is truncated, lists too many frames, or hides inner frames."""
        if self._file is None or "mp4" not in self._formats:
            return False
        bounds = range(MAX_REORDERED_FRAMES, self._shown - MAX_REORDERED_FRAMES)
        hides = any(after in bounds for after in self._hidden_after) and has_one_edit(self._file)
        hides |= self._hidden > 0 and self._is_too_long(self._file)
        return hides or self._announced > self._file.stat().st_size or bool(find_corrections(self._file))

    def _is_too_long(self, file: Path) -> bool:
        """Whether frames exceed the duration of an MP4 track, which includes hidden frames."""
        begin, end = self._bounds
        whole = track_seconds(file, self._stream.id)
        return bool(whole) and end - begin > whole + DURATION_TOLERANCE_SECONDS

    def _announced_frames(self) -> int:
        """Return the number of video packets by the container's index; 0 if unknown."""
        if "avi" in self._formats:
            return len(self._stream.index_entries)
        return self._stream.frames if "mp4" in self._formats else 0

    def _announced_seconds(self, cut_off: bool) -> Fraction | None:
        """Return the duration by the header if the header does not count frames; None if unknown."""
        assert self._stream.time_base is not None
        whole = Fraction(self._container.duration or 0, av.time_base)
        if "matroska" in self._formats:
            return whole if self._file is None or states_duration(self._file) else None
        # These durations also include the last frame's and skipped frames, so they exceed complete files.
        if "flv" in self._formats and cut_off:
            return whole
        if "avi" in self._formats and self._file is not None and ends_early(self._file, self._formats):
            return self._stream.frames * self._stream.time_base
        return None


def _count_blocks_after(file: BinaryIO, position: int) -> int:
    """Count the complete blocks of the same track that follow a block of a Matroska file.

    Args:
        position: offset of the content of the block, after its header.
    """
    before = _read_at(file, position - ELEMENT_HEADER_BYTES, ELEMENT_HEADER_BYTES)
    track, end, count = _read_at(file, position, 1), os.fstat(file.fileno()).st_size, 0
    # The header is an identifier of one byte, and a size of 1 to 8 bytes, given by its first byte.
    starts = [position - 1 - width for width in range(1, 9) if before[-width - 1 : -width] in BLOCK_IDS]
    elements = (_read_element(file, start) for start in starts)
    offset = next((start + size for _, start, size in elements if start == position), end)
    for _ in range(MAX_ELEMENTS):
        if offset >= end:
            break
        name, start, size = _read_element(file, offset)
        if not name:
            break
        is_whole = start + size <= end
        count += name in BLOCK_IDS and is_whole and _read_at(file, start, 1) == track
        offset = start if name in PARENT_IDS else start + size
    return count


def _read_element(file: BinaryIO, offset: int) -> tuple[bytes, int, int]:
    """Return identifier, offset and size of the content of a Matroska element (RFC 8794, sections 4 and 5).

    The identifier is empty if there is no element at this offset.
    """
    header = _read_at(file, offset, ELEMENT_HEADER_BYTES) or b"\0"
    name = header[: 9 - header[0].bit_length()] if header[0] >= MIN_ID_BYTE else b""
    first = header[len(name) :][:1] or b"\0"
    width = 9 - first[0].bit_length()
    size = int.from_bytes(header[len(name) :][:width]) & (1 << 7 * width) - 1
    return name, offset + len(name) + width, size


def _read_at(file: BinaryIO, offset: int, size: int) -> bytes:
    file.seek(max(0, offset))
    return file.read(size)
