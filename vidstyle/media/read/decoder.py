"""Decoding that survives errors: a damaged packet costs one frame, not the film."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import av
from av.codec.context import Flags

from vidstyle.core.cores import imposed_threads
from vidstyle.errors import is_memory_short, log
from vidstyle.media.exif import hide_png_exif
from vidstyle.media.frame import DecodedFrame
from vidstyle.media.read.clock import FrameClock
from vidstyle.media.read.decode_report import DecodeReport

ALPHA_DECODERS = {"vp8": "libvpx", "vp9": "libvpx-vp9"}
"""FFmpeg's own decoders of these leave the alpha channel out."""
MAX_RECENT_BYTES = 2**26
"""Packets are kept up to this size for decoding the end of a damaged film once more."""


class Decoder:
    """Decodes one video stream packet by packet.

    Attributes:
        damage: counts of what failed.
        codec: FFmpeg's name of the decoder.
    """

    def __init__(
        self,
        stream: av.video.stream.VideoStream,
        clock: FrameClock,
        damage: DecodeReport,
        max_pixels: int,
    ) -> None:
        self.damage = damage
        self._clock = clock
        self._stream, self._max_pixels = stream, max_pixels
        self._context: Any = _context(stream, max_pixels)
        self.codec = str(self._context.name)
        self._forget()
        self._enters_at_key: bool | None = None

    def _forget(self) -> None:
        self._awaited: list[int] = []
        self._gaps: list[int] = []
        self._recent: list[av.Packet] = []
        self._recent_bytes = self._failures = self._interval = 0
        self._highest: int | None = None
        self._newest: int | None = None
        self._last: av.VideoFrame | None = None
        self._enters_at_key = True

    def decode(self, packet: av.Packet | None, after_gap: bool = False) -> Iterator[DecodedFrame]:
        """The frames that come out when a packet goes in, after those repeated for failed packets.

        Args:
            packet: None flushes the decoder; what failed at the very end is lost.
            after_gap: whether there was something before the packet that could not be read.
        """
        if packet is None:
            yield from self._flush()
            return
        if self.codec == "png":
            packet = _without_exif(packet)
        if self._enters_at_key is None:
            self._enters_at_key = packet.is_keyframe
        if packet.pts is not None:
            if after_gap and self._highest is not None:
                self._gaps.append(self._highest)
            self._highest = max(packet.pts, self._highest or packet.pts)
            if not packet.is_discard:
                self._awaited.append(packet.pts)
            self._remember(packet)
        yield from self._decoded(self._context, packet)

    def forget_gaps(self) -> None:
        """Take what could not be read for nothing: the time begins anew here."""
        self._gaps.clear()

    def reset(self) -> None:
        """Forget the packets seen, before a seek; `damage` keeps its counts."""
        self._context.flush_buffers()
        self._clock.reset()
        self._forget()

    def _decoded(
        self, context: Any, packet: av.Packet | None, after: int | None = None
    ) -> Iterator[DecodedFrame]:
        """What a context makes of a packet, as far as it is shown after a time."""
        try:
            frames = context.decode(packet)
        except av.EOFError:
            return
        except av.FFmpegError as error:
            if is_memory_short():
                raise MemoryError from error
            log.debug("a packet could not be decoded: %s", error)
            stamp = None if packet is None else packet.pts
            self._failures += after is None or (stamp is not None and stamp > after)
            return
        for frame in frames:
            if after is None or (frame.pts is not None and frame.pts > after):
                self._push(frame)
                yield from self._clock.pull()

    def _flush(self) -> Iterator[DecodedFrame]:
        yield from self._decoded(self._context, None)
        after = self._newest
        if self._awaited and after is not None and self._recent and self._recent[0].is_keyframe:
            # Threads that are flushed stop at the first error, with good frames behind it.
            self._failures = 0
            context = _context(self._stream, self._max_pixels, frame_threads=False)
            for packet in (*self._recent, None):
                yield from self._decoded(context, packet, after)
        self.damage.lost += self._failures
        self._failures = 0
        yield from self._clock.pull(flush=True)

    def _remember(self, packet: av.Packet) -> None:
        """Keep the packets from the last key frame on that has come out: what a flush may have to repeat."""
        if packet.is_keyframe:
            shown = -math.inf if self._newest is None else self._newest
            keys = [
                number
                for number, each in enumerate(self._recent)
                if each.is_keyframe and each.pts is not None and each.pts <= shown
            ]
            del self._recent[: keys[-1] if keys else 0]
            self._recent_bytes = sum(each.size for each in self._recent)
        self._recent.append(packet)
        self._recent_bytes += packet.size
        if self._recent_bytes > MAX_RECENT_BYTES:
            self._recent.clear()
            self._recent_bytes = 0

    def _push(self, frame: av.VideoFrame) -> None:
        if self._last is None and frame.is_corrupt and not frame.key_frame:
            # Made of nothing, where a film begins between key frames.
            return
        # Formats without display times give the decoding time.
        pts: int | None = frame.pts if frame.pts is not None else frame.dts
        self._fill(pts)
        if pts is not None and self._newest is not None:
            self._interval = pts - self._newest
        self._last, self._newest = frame, pts
        self.damage.decoded += 1
        self.damage.concealed += bool(frame.is_corrupt)
        self._clock.push(frame, pts)

    def _fill(self, pts: int | None) -> None:
        """Repeat the last good frame in the slots that packets announced before this one, if any have failed.

        Without a failure an empty slot is none: some codecs have packets that show nothing. A failure may
        come before its slot, since decoders work ahead on several threads.
        """
        empty = sorted(stamp for stamp in self._awaited if pts is not None and stamp < pts)
        if self._last is not None or self._enters_at_key:
            empty = empty[: self._failures]
        self._awaited = [stamp for stamp in self._awaited if pts is not None and stamp > pts]
        self._failures = max(0, self._failures - len(empty))
        self._count_missing(pts, empty)
        if self._last is None:
            self.damage.lost += len(empty)
            return
        for slot in empty:
            self.damage.repeated += 1
            self._clock.push(self._last, slot, repeated=True)

    def _count_missing(self, pts: int | None, filled: list[int]) -> None:
        """Count the frames for which there is time in a gap of the file that ends with this one."""
        if pts is None or not self._gaps or pts <= self._gaps[0]:
            return
        start = self._gaps[0]
        step = max((self._last and self._last.duration) or self._clock.step, self._interval)
        missing = round((pts - start) / step) - 1 - sum(slot > start for slot in filled)
        self.damage.missing_frames += max(0, missing)
        self._gaps = [gap for gap in self._gaps if gap >= pts]


def _without_exif(packet: av.Packet) -> av.Packet:
    """The packet of a PNG, or one with the same picture that the decoder does not refuse for damaged EXIF."""
    content = bytes(packet)
    if b"eXIf" not in content:
        return packet
    bare = av.Packet(hide_png_exif(content))
    bare.pts, bare.dts, bare.time_base, bare.duration = (
        packet.pts,
        packet.dts,
        packet.time_base,
        packet.duration,
    )
    bare.is_keyframe = packet.is_keyframe
    return bare


def _context(stream: av.video.stream.VideoStream, max_pixels: int, frame_threads: bool = True) -> Any:
    """The stream's decoder, on as many threads as are worth it, or the one that knows alpha.

    Without `frame_threads` it is another one, which fails at the packet that is at fault.
    """
    given = stream.codec_context
    alpha = (
        ALPHA_DECODERS.get(given.codec.canonical_name) if stream.metadata.get("alpha_mode") == "1" else None
    )
    context: Any = given
    if alpha or not frame_threads:
        context = av.CodecContext.create(alpha or given.name, "r")
        context.extradata = given.extradata
        context.width, context.height = given.width, given.height
        context.codec_tag = given.codec_tag
        context.bits_per_coded_sample = given.bits_per_coded_sample
    # Frames whose references are lost are shown, patched, rather than left out.
    context.flags |= Flags.output_corrupt
    context.thread_type = "AUTO" if frame_threads else "SLICE"
    context.thread_count = imposed_threads()
    # av.open's option reaches only the probing.
    context.options = {"max_pixels": str(max_pixels)}
    return context
