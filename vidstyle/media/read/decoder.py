"""Decoding that survives errors: a damaged packet costs one frame, not the film."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import av

from vidstyle.media.frame import DecodedFrame
from vidstyle.media.read.clock import FrameClock

log = logging.getLogger("vidstyle")

MAX_FAILURES = 8
"""After so many packets in a row that do not decode, decoding waits for the next key frame."""
ALPHA_DECODERS = {"vp8": "libvpx", "vp9": "libvpx-vp9"}
"""FFmpeg's own decoders of these leave the alpha channel out."""


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
        self._context: Any = _context(stream, max_pixels)
        self.codec = str(self._context.name)
        self._awaited: list[int] = []
        self._failures = 0
        self._in_a_row = 0
        self._last: av.VideoFrame | None = None

    def decode(self, packet: av.Packet | None) -> Iterator[DecodedFrame]:
        """The frames that come out when a packet goes in, after those repeated for failed packets.

        None in place of a packet flushes the decoder; what failed at the very end is lost.
        """
        if packet is not None:
            if self._in_a_row >= MAX_FAILURES and not packet.is_keyframe:
                self.damage.lost += 1
                return
            if packet.pts is not None and not packet.is_discard:
                self._awaited.append(packet.pts)
        try:
            for frame in self._context.decode(packet):
                self._push(frame)
                yield from self._clock.pull()
        except av.EOFError:
            pass
        except av.FFmpegError as error:
            log.debug("a packet could not be decoded: %s", error)
            self._failures += 1
            self._in_a_row += 1
        if packet is None:
            self.damage.lost += self._failures
            self._failures = 0
            yield from self._clock.pull(flush=True)

    def reset(self) -> None:
        """Forget the packets seen, before a seek; `damage` keeps its counts."""
        self._context.flush_buffers()
        self._clock.reset()
        self._awaited.clear()
        self._failures = self._in_a_row = 0
        self._last = None

    def _push(self, frame: av.VideoFrame) -> None:
        # Formats without display times give the decoding time.
        pts: int | None = frame.pts if frame.pts is not None else frame.dts
        self._fill(pts)
        self._in_a_row = 0
        self._last = frame
        self.damage.decoded += 1
        self.damage.concealed += bool(frame.is_corrupt)
        self._clock.push(frame, pts)

    def _fill(self, pts: int | None) -> None:
        """Repeat the last good frame in the slots that packets announced before this one, if any have failed.

        Without a failure an empty slot is none: some codecs have packets that show nothing. A failure may
        come before its slot, since decoders work ahead on several threads.
        """
        empty = sorted(stamp for stamp in self._awaited if pts is not None and stamp < pts)[: self._failures]
        self._awaited = [stamp for stamp in self._awaited if pts is not None and stamp > pts]
        self._failures -= len(empty)
        if self._last is None or self._in_a_row >= MAX_FAILURES:
            self.damage.lost += len(empty)
            return
        for slot in empty:
            self.damage.repeated += 1
            self._clock.push(self._last, slot, repeated=True)


def _context(stream: av.video.stream.VideoStream, max_pixels: int) -> Any:
    """The stream's decoder, on as many threads as are worth it, or the one that knows alpha."""
    codec = stream.codec_context.codec.canonical_name
    if stream.metadata.get("alpha_mode") == "1" and codec in ALPHA_DECODERS:
        context: Any = av.CodecContext.create(ALPHA_DECODERS[codec], "r")
        context.extradata = stream.codec_context.extradata
    else:
        context = stream.codec_context
    context.thread_type = "AUTO"
    # av.open's option reaches only the probing.
    context.options = {"max_pixels": str(max_pixels)}
    return context


CONCEALED_SHARE = 0.01
"""Up to this share of frames that a decoder has patched by itself nobody need hear of."""
DURATION_TOLERANCE = Fraction(1, 2)
"""Seconds by which a file may end before its header says so; headers round, and count the sound."""


@dataclass
class DecodeReport:
    """Counts of a reading that is still under way or over.

    Attributes:
        decoded: frames delivered from packets of their own.
        repeated: frames that could not be decoded and were replaced by the last good one.
        lost: frames that could not be decoded and left nothing.
        concealed: frames that the decoder delivered, but flagged as patched.
        missing_frames: frames that the header announces and the file does not hold.
        missing_seconds: how much earlier than its header says the file ends, where frames are not counted.
        header_seconds: what the header says.
        broken_reads: places where the container itself could not be read.
    """

    decoded: int = 0
    repeated: int = 0
    lost: int = 0
    concealed: int = 0
    missing_frames: int = 0
    missing_seconds: Fraction = Fraction(0)
    header_seconds: Fraction = Fraction(0)
    broken_reads: int = 0

    @property
    def is_significant(self) -> bool:
        """Whether a program should end with another code than success."""
        undone = self.repeated + self.lost + self.missing_frames
        return bool(undone or self.missing_seconds) or self.concealed > CONCEALED_SHARE * self.decoded

    def report(self) -> str:
        """One line for people, or "" when nothing was found.

        >>> DecodeReport(decoded=72, missing_frames=78).report()
        'the input is damaged: 78 frames missing of 150'
        """
        total = self.decoded + self.repeated + self.lost + self.missing_frames
        missing, said = float(self.missing_seconds), float(self.header_seconds)
        found = [
            (self.missing_frames, f"{_frames(self.missing_frames)} missing of {total}"),
            (self.repeated, f"{_frames(self.repeated)} damaged, the last good one held"),
            (self.lost, f"{_frames(self.lost)} damaged and left out"),
            (self.concealed, f"{_frames(self.concealed)} patched by the decoder"),
            (self.missing_seconds, f"it ends {missing:.1f} s before the {said:.1f} s that its header says"),
        ]
        words = [text for count, text in found if count]
        return "the input is damaged: " + ", ".join(words) if words else ""


def _frames(count: int) -> str:
    return f"{count} frame" + "s" * (count != 1)
