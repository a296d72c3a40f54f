"""A segment of a film in a file: encoded packets, which are joined later, and their digest.

The packets are followed by an index in JSON and by its length in 8 bytes. Containers would round times,
require start codes or length prefixes, and have no digest.
"""

from __future__ import annotations

import base64
import hashlib
import io
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import av

from vidstyle.errors import InputError, OutputError, UsageError
from vidstyle.media.frame import Frame
from vidstyle.media.write.atomic import OutputFile
from vidstyle.media.write.base import Writer, write_error
from vidstyle.media.write.encoder import VideoEncoder

_LENGTH_BYTES = 8
MAX_INDEX_BYTES = 2**28


@dataclass
class SegmentIndex:
    """Index of a segment file.

    Attributes:
        time_base: time base of the packets, in seconds.
        frame_time_base: time base of the frames.
        headers: encoder headers in base64.
        frames: pts and duration of each frame, in presentation order.
        packets: pts, dts, key frame flag and size of each packet, in file order.
        sha256: digest of all packets.
        memory: digests of the renderer's state before the first and after the last frame; empty if the
            segment before it, or after it, belongs to another scene.
    """

    time_base: str
    frame_time_base: str
    headers: str
    frames: list[tuple[int, int]] = field(default_factory=list)
    packets: list[tuple[int, int, bool, int]] = field(default_factory=list)
    sha256: str = ""
    memory: tuple[str, str] = "", ""


class SegmentWriter(Writer):
    """Encodes frames into a segment file, with the settings of a film; see `open_writer` for its arguments.

    The file appears when it is complete.

    Attributes:
        memory: returns the digests for `SegmentIndex.memory`; called after the last frame.
    """

    memory: Callable[[], tuple[str, str]]

    def _open(self) -> None:
        self._file = OutputFile(self.target, self._source_path, overwrite=True)
        self._sink = self._file.path.open("wb")
        # No packet is written there: its format determines how the encoder stores its headers.
        self._container = av.open(io.BytesIO(), "w", format=self._kind.muxer)
        self._video = VideoEncoder(self._container, self._plan)
        headers = bytes(self._video.stream.codec_context.extradata or b"")
        self._index = SegmentIndex(str(self._plan.time_base), "", base64.b64encode(headers).decode())
        self._digest, self.memory = hashlib.sha256(), lambda: ("", "")

    def write(self, item: Frame | av.Packet) -> None:
        """See Writer; packets of other streams are not stored."""
        if not isinstance(item, Frame):
            return
        self.frames += 1
        self._index.frame_time_base = str(item.time_base)
        self._index.frames.append((item.pts, item.duration or 0))
        try:
            self._store(self._video.encode(item))
            self._file.check()
        except (av.FFmpegError, OSError) as error:
            raise self._failure(error) from error

    def finish(self) -> None:
        """See Writer."""
        try:
            self._store(self._video.flush())
            self._index.sha256, self._index.memory = self._digest.hexdigest(), self.memory()
            index = json.dumps(asdict(self._index)).encode()
            self._sink.write(index + len(index).to_bytes(_LENGTH_BYTES, "big"))
            self._sink.close()
            self._file.finish()
        except (av.FFmpegError, OSError) as error:
            raise self._failure(error) from error

    def abandon(self) -> None:
        """See Writer; no file is kept."""
        self._sink.close()
        self._file.remove()

    def _store(self, packets: Iterator[av.Packet] | list[av.Packet]) -> None:
        for packet in packets:
            content = bytes(packet)
            assert packet.pts is not None and packet.dts is not None
            self._index.packets.append((packet.pts, packet.dts, packet.is_keyframe, len(content)))
            self._digest.update(content)
            self._sink.write(content)

    def _failure(self, error: Exception) -> Exception:
        self.abandon()
        return write_error(self.name, error, "nothing is kept")


def read_index(path: Path) -> SegmentIndex:
    """Return the index of a segment file, after comparing its packets with their digest.

    Raises:
        InputError: the file is damaged or not a segment.
        OSError: the file cannot be read.
    """
    with path.open("rb") as file:
        try:
            index = _index_at_end(file)
            file.seek(0)
            sizes = [size for _, _, _, size in index.packets]
            digest = hashlib.sha256()
            for size in sizes:
                digest.update(file.read(size))
        except (ValueError, TypeError, KeyError, RecursionError) as error:
            raise InputError(path, f"is not a complete segment ({error})") from error
    if digest.hexdigest() != index.sha256:
        raise InputError(path, "is damaged: its digest differs")
    return index


def _index_at_end(file: Any) -> SegmentIndex:
    end = file.seek(0, io.SEEK_END)
    file.seek(max(0, end - _LENGTH_BYTES))
    length = int.from_bytes(file.read(_LENGTH_BYTES), "big")
    if not 0 < length <= min(end - _LENGTH_BYTES, MAX_INDEX_BYTES):
        raise ValueError("its index is missing")
    file.seek(end - _LENGTH_BYTES - length)
    content = json.loads(file.read(length))
    return SegmentIndex(**{**content, "memory": tuple(content["memory"])})


class JoinedSegments:
    """The packets of consecutive segments, as from one encoder.

    Attributes:
        headers: encoder headers.
        tick: time base of the packets, in seconds.
        indexes: indexes of the segments.

    Raises:
        InputError: a segment is damaged, or its encoder settings differ from the first segment's.
        UsageError: a segment is missing.
        OSError: a segment cannot be read.
    """

    def __init__(self, paths: Sequence[Path]) -> None:
        self._paths = paths
        if missing := next((path for path in paths if not path.exists()), None):
            raise UsageError(missing, "does not exist", "run the command with --range first")
        self.indexes = [read_index(path) for path in paths]
        first = self.indexes[0]
        for path, index in zip(paths, self.indexes, strict=True):
            if (index.headers, index.time_base) != (first.headers, first.time_base):
                raise InputError(path, "was encoded with settings that differ from the first segment's")
        self.headers, self.tick = base64.b64decode(first.headers), Fraction(first.time_base)

    def frames(self) -> Iterator[tuple[int, int, Fraction]]:
        """Yield pts, duration and time base of each frame."""
        for index in self.indexes:
            base = Fraction(index.frame_time_base)
            yield from ((pts, duration, base) for pts, duration in index.frames)

    def packets(self) -> Iterator[tuple[Fraction, av.Packet]]:
        """Yield all packets in decoding order, each with the time of the frame with the same number.

        Raises:
            OutputError: after the packets of a segment that was replaced meanwhile, as by a process that has
                rendered it a second time.
        """
        for path, index in zip(self._paths, self.indexes, strict=True):
            shown = sorted(pts for pts, _, _, _ in index.packets)
            digest = hashlib.sha256()
            with path.open("rb") as file:
                for time, (pts, dts, is_key, size) in zip(shown, index.packets, strict=True):
                    content = file.read(size)
                    digest.update(content)
                    packet = av.Packet(content)
                    packet.pts, packet.dts, packet.time_base = pts, dts, self.tick
                    packet.is_keyframe = is_key
                    yield time * self.tick, packet
            if digest.hexdigest() != index.sha256:
                raise OutputError(path, "was replaced while it was joined")
