"""Decoding with error recovery: a damaged packet costs one frame, not the film."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import av
from av.codec.context import Flags

from vidstyle.core.machine.cores import imposed_threads
from vidstyle.errors import is_memory_short, log
from vidstyle.media.color_tags import clear_reserved_matrix
from vidstyle.media.exif import hide_png_exif
from vidstyle.media.frame import DecodedFrame
from vidstyle.media.read.clock import FrameClock
from vidstyle.media.read.decode_report import DecodeReport

ALPHA_DECODERS = {"vp8": "libvpx", "vp9": "libvpx-vp9"}
"""Decoders with alpha channel, by codec; FFmpeg's native decoders of these codecs ignore it."""
ALWAYS_SHOWN_CODECS = frozenset({"hevc", "vvc", "av1"})
"""Codecs in which every packet after the first frame shows a frame; their decoders may drop one silently."""
MAX_RECENT_BYTES = 2**26
"""Maximum size of the packets that are kept to decode the end of a damaged film again."""


class Decoder:
    """Decodes one video stream packet by packet.

    Attributes:
        damage: counts of the damage.
        codec: FFmpeg's name of the decoder.
    """

    def __init__(
        self,
        stream: av.video.stream.VideoStream,
        clock: FrameClock,
        damage: DecodeReport,
        max_pixels: int,
        shows_any: bool = True,
    ) -> None:
        """Set up the decoder.

        Args:
            shows_any: whether frames decoded without a key frame are shown if there are no others.
        """
        self.damage = damage
        self._clock, self._shows_any = clock, shows_any
        self._stream, self._max_pixels = stream, max_pixels
        self._context: Any = _open_context(stream, max_pixels)
        self.codec = str(self._context.name)
        self._always_shows = stream.codec_context.codec.canonical_name in ALWAYS_SHOWN_CODECS
        self._clear()
        self._enters_at_key: bool | None = None

    def _clear(self) -> None:
        self._awaited: list[int] = []
        self._overdue: set[int] = set()
        self._gaps: list[int] = []
        self._recent: list[av.Packet] = []
        self._recent_bytes = self._failures = self._interval = 0
        self._highest: int | None = None
        self._newest: int | None = None
        self._last: av.VideoFrame | None = None
        self._enters_at_key = True
        self._shows_patched = False
        self._patched: list[int | None] = []

    def decode(self, packet: av.Packet | None, after_gap: bool = False) -> Iterator[DecodedFrame]:
        """Decode a packet; yield the repeated frames for failed packets, then the decoded frames.

        Args:
            packet: None flushes the decoder; failures at the very end are counted as lost.
            after_gap: whether data before the packet could not be read.
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
        yield from self._decode_packet(self._context, packet)

    def forget_gaps(self) -> None:
        """Ignore gaps so far, as timestamps start again here."""
        self._gaps.clear()

    def reset(self) -> None:
        """Clear the state before a seek; `damage` keeps its counts."""
        self._context.flush_buffers()
        self._clock.reset()
        self._clear()

    def _decode_packet(
        self, context: Any, packet: av.Packet | None, after: int | None = None
    ) -> Iterator[DecodedFrame]:
        """Decode a packet with a context; yield the frames that are shown after a time."""
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
                clear_reserved_matrix(frame)
                self._push(frame)
                yield from self._clock.pull()

    def _flush(self) -> Iterator[DecodedFrame]:
        yield from self._decode_packet(self._context, None)
        is_timed = self._newest is not None or self._last is None
        if self._awaited and is_timed and self._recent and self._recent[0].is_keyframe:
            yield from self._decode_again(self._newest)
        if self._last is None and self._shows_any and 2 * len(self._patched) >= max(1, len(self._awaited)):
            self._shows_patched = True  # most packets yield one; random data yields few
            yield from self._decode_again(None)
        if self._always_shows or self._last is None:
            self._failures = max(self._failures, len(self._overdue) + len(self._awaited))
        else:  # dropped frames whose packets have wrong times
            self._failures = max(self._failures, len({*self._patched} & {*self._awaited}))
        self.damage.lost += self._failures
        self._failures = 0
        yield from self._clock.pull(flush=True)

    def _decode_again(self, after: int | None) -> Iterator[DecodedFrame]:
        """Decode the last packets again; yield the frames that are shown after a time.

        Frame threads that are flushed stop at the first error, even if good frames follow.
        """
        self._failures = 0
        self._patched.clear()
        context = _open_context(self._stream, self._max_pixels, threads=False)
        for packet in (*self._recent, None):
            yield from self._decode_packet(context, packet, after)

    def _remember(self, packet: av.Packet) -> None:
        """Keep the packets since the last decoded key frame, which a flush may have to decode again."""
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
        if self._last is None and frame.is_corrupt and not frame.key_frame and not self._shows_patched:
            # A frame without references, if a film starts between key frames.
            self._patched.append(frame.pts)
            return
        # Formats without presentation times have decoding times.
        pts: int | None = frame.pts if frame.pts is not None else frame.dts
        self._fill_slots(pts)
        if pts is not None and self._newest is not None:
            self._interval = pts - self._newest
        self._overdue -= {pts}
        self._last, self._newest = frame, pts
        self.damage.decoded += 1
        self.damage.concealed += bool(frame.is_corrupt)
        self._clock.push(frame, pts)

    def _fill_slots(self, pts: int | None) -> None:
        """Repeat the last good frame for failed packets before this frame.

        Without a failure, an empty slot is no loss for codecs that have packets without a frame. A failure
        may be reported before its slot, since decoders work ahead on several threads.
        """
        empty = sorted(stamp for stamp in self._awaited if pts is not None and stamp < pts)
        if self._last is not None and self._always_shows:
            self._overdue.update(empty[self._failures :])
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
        """Estimate the number of frames in a gap of the file that ends with this frame."""
        if pts is None or not self._gaps or pts <= self._gaps[0]:
            return
        start = self._gaps[0]
        step = max((self._last and self._last.duration) or self._clock.step, self._interval)
        missing = round((pts - start) / step) - 1 - sum(slot > start for slot in filled)
        self.damage.missing_frames += max(0, missing)
        self._gaps = [gap for gap in self._gaps if gap >= pts]


def _without_exif(packet: av.Packet) -> av.Packet:
    """Return the packet of a PNG without EXIF, as the decoder rejects pictures with damaged EXIF."""
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


def _open_context(stream: av.video.stream.VideoStream, max_pixels: int, threads: bool = True) -> Any:
    """Return the stream's decoder, or another one of its codec that supports alpha.

    Without `threads` it is a new decoder with one thread, which fails at the damaged packet itself.
    """
    given = stream.codec_context
    alpha = (
        ALPHA_DECODERS.get(given.codec.canonical_name) if stream.metadata.get("alpha_mode") == "1" else None
    )
    context: Any = given
    if alpha or not threads:
        context = av.CodecContext.create(alpha or given.name, "r")
        context.extradata = given.extradata
        context.width, context.height = given.width, given.height
        context.codec_tag = given.codec_tag
        context.bits_per_coded_sample = given.bits_per_coded_sample
    # Show frames with lost references, with errors concealed, instead of dropping them.
    context.flags |= Flags.output_corrupt
    context.thread_type = "AUTO" if threads else "SLICE"
    context.thread_count = imposed_threads() if threads else 1
    # The option of av.open applies only to probing.
    context.options = {"max_pixels": str(max_pixels)}
    return context
