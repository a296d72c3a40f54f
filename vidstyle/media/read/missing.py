"""What is missing from a file: parts that cannot be read, frames and time that its header announces."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av

from vidstyle.media.read.decode_report import DURATION_TOLERANCE, DecodeReport
from vidstyle.media.read.headers import ends_early, states_duration
from vidstyle.media.read.mp4_tables import cut_counts, has_one_edit

FORMATS_WITHOUT_HOLES = frozenset({"matroska", "webm", "flv", "nut", "avi"})
"""Formats in which little but packets lies between the first packet and the last."""
MAX_BETWEEN_PACKETS = 1024
"""Bytes that such a format puts between two packets at most."""
MAX_REORDERED = 16
"""So many frames from an end of a part, a hidden one may lie beyond it: the most that codecs reorder."""
NEAR_CORRUPT = 8
"""Among so many packets is the gap for which one of them is marked: demuxers mark it early."""


class GapFinder:
    """Finds what could not be read between packets: holes in the file, and what the demuxer marks."""

    def __init__(self, formats: set[str], reads_all: bool) -> None:
        """Begin before the first packet.

        Args:
            formats: FFmpeg's names of the container's format.
            reads_all: whether every packet of the file comes.
        """
        self._shows_holes = reads_all and bool(formats & FORMATS_WITHOUT_HOLES)
        self._position = self._end = 0
        self._suspects = 0

    def look(self, packet: av.Packet) -> None:
        """Take the next packet of the file."""
        if packet.is_corrupt:
            self._suspects = NEAR_CORRUPT
        if packet.pos is None:
            return
        if self._shows_holes and packet.pos > self._end + MAX_BETWEEN_PACKETS and self._end:
            self.suspect()
        # Several that lie in one block have its position.
        start = self._end if packet.pos == self._position else packet.pos
        self._position, self._end = packet.pos, max(self._end, start + packet.size)

    def suspect(self) -> None:
        """Note that something before the next packet could not be read."""
        self._suspects = max(1, self._suspects)

    def forget(self) -> None:
        """Take what could not be read for nothing."""
        self._suspects = 0

    def before_picture(self) -> bool:
        """Whether there may be a gap before the packet just taken, which is the film's; ask once for each."""
        found = self._suspects > 0
        self._suspects -= found
        return found


class HeaderCheck:
    """Compares what is read of a film with what the header of its container says.

    Attributes:
        packets: how many of the film have come.
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
        self._end = self._start = self._longest = Fraction(0)
        self._announced = self._announced_frames()

    def count(self, packet: av.Packet) -> None:
        """Take a packet of any stream."""
        if packet.pts is not None:
            self._end = max(self._end, (packet.pts + (packet.duration or 0)) * packet.time_base)
        if packet.stream_index != self._stream.index:
            return
        if packet.dts is not None:
            start = packet.dts * packet.time_base
            self._longest = max(self._longest, start - self._start) if self.packets else Fraction(0)
            self._start = start
        self.packets += 1
        if packet.is_discard:
            self._hidden += 1
            self._hidden_after.append(self._shown)
        else:
            self._shown += 1

    def shows_cut(self) -> bool:
        """Whether the file ends before the last frame that it announces, known without reading frames."""
        if self._file is None:
            return False
        size = self._file.stat().st_size
        indexed = self._stream.index_entries if "mp4" in self._formats else ()
        return any(each.pos + each.size > size for each in indexed) or ends_early(self._file, self._formats)

    def compare(self, damage: DecodeReport) -> None:
        """Report what is missing: a file that was cut off ends without an error; only its header knows."""
        if self._file is not None:
            damage.cut_off |= ends_early(self._file, self._formats)
        if self._has_bad_index():
            damage.has_bad_index = True
        elif self.packets < self._announced:
            # Every one that is not delivered is missing, that of a packet cut in two included.
            damage.missing_frames = self._announced - self._hidden - damage.decoded - damage.repeated
            damage.lost = 0
        elif not damage.leaps and (announced := self._announced_seconds(damage.cut_off)):
            # Where frames are held for long, the last one may be.
            if announced - self._end > max(DURATION_TOLERANCE, announced / 100, self._longest):
                damage.missing_seconds = announced - self._end
                damage.header_seconds = announced

    def _has_bad_index(self) -> bool:
        """Whether tables of an MP4 file are cut off, announce too many frames, or hide some amid the film."""
        if self._file is None or "mp4" not in self._formats:
            return False
        bounds = range(MAX_REORDERED, self._shown - MAX_REORDERED)
        hides = any(after in bounds for after in self._hidden_after) and has_one_edit(self._file)
        return hides or self._announced > self._file.stat().st_size or bool(cut_counts(self._file))

    def _announced_frames(self) -> int:
        """How many packets of the film there are by the container's index; 0: it does not say."""
        if "avi" in self._formats:
            return len(self._stream.index_entries)
        return self._stream.frames if "mp4" in self._formats else 0

    def _announced_seconds(self, cut_off: bool) -> Fraction | None:
        """How long the film is by its header, where that does not count its frames; None: it does not say."""
        assert self._stream.time_base is not None
        whole = Fraction(self._container.duration or 0, av.time_base)
        if "matroska" in self._formats:
            return whole if self._file is None or states_duration(self._file) else None
        # These count what whole files lack, too: how long the last frame is held, frames that were left out.
        if "flv" in self._formats and cut_off:
            return whole
        if "avi" in self._formats and self._file is not None and ends_early(self._file, self._formats):
            return self._stream.frames * self._stream.time_base
        return None
