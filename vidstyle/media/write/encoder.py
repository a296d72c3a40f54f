"""Encodes frames into packets with their timestamps and durations."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import av
import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.errors import OutputError, UsageError
from vidstyle.media.codecs import open_encoder
from vidstyle.media.frame import Frame, frame_from_picture
from vidstyle.media.write.video_plan import VideoPlan

MIN_TO_REORDER = 3
"""Minimum number of frames for reordering. With fewer, libx265 returns arbitrary decoding timestamps, as it
never sets the delay that it subtracts from them."""


class VideoEncoder:
    """One encoded video stream of a container.

    Raises:
        UsageError: the container does not support the codec.

    Attributes:
        stream: the stream in the container.
        end: end of the last frame, in seconds.
        surplus: seconds by which the last packet is longer than its frame.
        shifted: number of frames with duplicate timestamps, which were shifted by one tick.
    """

    def __init__(self, container: av.container.OutputContainer, plan: VideoPlan) -> None:
        self.plan = plan
        try:
            stream = container.add_stream(plan.encoder, rate=plan.rate)
        except ValueError as error:
            reason = f"{container.format.name} files do not support {plan.codec}"
            raise UsageError("--codec", reason, "choose another codec or extension") from error
        assert isinstance(stream, av.VideoStream)
        self.stream = stream
        plan.configure(stream.codec_context)
        open_encoder(stream.codec_context)
        self.stream.time_base = plan.time_base
        self.end = Fraction(0)
        self.surplus = Fraction(0)
        self.shifted = 0
        self._last = -(2**62)
        self._taken = 0
        self._durations: dict[int | None, int] = {}
        self._previous_packet: av.Packet | None = None
        self._previous: Frame | None = None
        self._earlier: Iterator[tuple[Fraction, av.Packet]] = iter(())
        self._tick = Fraction(0)

    def resume(self, earlier: Iterator[tuple[Fraction, av.Packet]], tick: Fraction) -> None:
        """Use packets of an earlier run for the first frames instead of encoding them.

        Args:
            earlier: for each of the first frames, its time in seconds and the next packet.
            tick: precision of the times, in seconds.
        """
        self._earlier, self._tick = earlier, tick

    def encode(self, frame: Frame) -> list[av.Packet]:
        """Encode a frame; return packets, or none while the encoder looks ahead.

        Raises:
            OutputError: the earlier run has another frame at this time.
        """
        if self.plan.max_gap is not None and (fillers := self._fillers(frame, self.plan.max_gap)):
            return [packet for each in (*fillers, frame) for packet in self.encode(each)]
        pts, duration = self._next_pts(frame), self._duration(frame)
        self.end = (pts + duration) * self.plan.time_base
        stored = self._next_stored(pts)
        if stored is not None:
            return list(self._complete_previous(stored))
        native = to_encoder_frame(frame, self.plan)
        native.pts, native.time_base, native.duration = pts, self.plan.time_base, duration
        self._durations[pts] = duration
        self._taken += 1
        return [timed for packet in self.stream.encode(native) for timed in self._complete_previous(packet)]

    def _fillers(self, frame: Frame, max_gap: Fraction) -> list[Frame]:
        """Repeat the previous frame to divide a gap that is too long for codec or container."""
        last, self._previous = self._previous, frame
        base, fillers = self.plan.time_base, list[Frame]()
        while last is not None and frame.time - last.time > max_gap:
            last = replace(last, pts=int((last.time + max_gap) / base), time_base=base)
            fillers.append(last)
        return fillers

    def _next_stored(self, pts: int) -> av.Packet | None:
        """Return the next packet of an earlier run, with times as from the encoder; None at the end."""
        shown, packet = next(self._earlier, (None, None))
        if shown is None or packet is None:
            return None
        assert packet.pts is not None and packet.dts is not None and packet.time_base is not None
        base = self.plan.time_base
        if abs(shown - pts * base) > self._tick:
            raise OutputError("the unfinished film", f"has no frame at {float(pts * base):.3f} s")
        packet.pts, packet.dts = (
            round(stamp * packet.time_base / base) for stamp in (packet.pts, packet.dts)
        )
        packet.time_base, packet.stream = base, self.stream
        return packet

    def flush(self, seconds: float | None = None) -> Iterator[av.Packet]:
        """Flush the encoder, for at most `seconds`."""
        deadline = time.monotonic() + (seconds if seconds is not None else float("inf"))
        if self._taken:
            for packet in self.stream.codec_context.encode_lazy(None):
                packet.stream = self.stream
                if self._taken < MIN_TO_REORDER:
                    packet.dts = packet.pts
                yield from self._complete_previous(packet)
                if time.monotonic() > deadline:
                    break
        if self._previous_packet is not None:
            self._previous_packet.duration = self._last_duration(self._previous_packet)
            yield self._previous_packet
            self._previous_packet = None

    def _next_pts(self, frame: Frame) -> int:
        """Return the frame's timestamp in the encoder's time base, strictly increasing."""
        pts = frame.pts
        if frame.time_base != self.plan.time_base:
            pts = round(frame.time / self.plan.time_base)
        if pts <= self._last:
            self.shifted += 1
            pts = self._last + 1
        self._last = pts
        return pts

    def _duration(self, frame: Frame) -> int:
        seconds = frame.duration * frame.time_base if frame.duration else 1 / self.plan.rate
        return max(1, round(seconds / self.plan.time_base))

    def _complete_previous(self, packet: av.Packet) -> Iterator[av.Packet]:
        """Yield the previous packet, with a duration until the decoding time of this one.

        The MP4 muxer joins its fragments by the durations of their last packets.
        """
        held, self._previous_packet = self._previous_packet, packet
        if held is not None:
            duration = self._durations.pop(held.pts, 1)
            if packet.dts is not None and held.dts is not None:
                # The first of an encoder may come as early as the last stored ones.
                packet.dts = max(packet.dts, held.dts + 1)
                duration = max(1, packet.dts - held.dts)
            held.duration = duration
            yield held

    def _last_duration(self, packet: av.Packet) -> int:
        """Return the duration until the end of the film, which another frame may define.

        The MP4 muxer ends the track with the last packet, and would cut off frames that are shown later.
        """
        duration = self._durations.pop(packet.pts, 1)
        if packet.pts is None or self._durations:
            return duration
        whole = max(duration, round(self.end / self.plan.time_base) - packet.pts)
        self.surplus = (whole - duration) * self.plan.time_base
        return whole


def to_encoder_frame(frame: Frame, plan: VideoPlan) -> av.VideoFrame:
    """Return the frame for the encoder: the decoded frame if it is unchanged, else a new one."""
    native, (width, height) = frame.native, plan.size
    if native is None or (native.format.name, native.width, native.height) != (plan.pix_fmt, width, height):
        native = frame_from_picture(fit_planes(frame.picture, plan), (height, width), plan.tags)
    plan.tags.put_on(native)
    native.pict_type = 0  # the encoder decides, independent of the source
    return native


def fit_planes(picture: Picture, plan: VideoPlan) -> Picture:
    """Convert the picture to the planes of the plan; add neutral chroma and opaque alpha if needed.

    Raises:
        ValueError: its samples do not have the plan's encoding.
    """
    encoding, wanted = picture.encoding, plan.encoding
    same_step = plan.rgb or picture.chroma is None or encoding.subsampling == wanted.subsampling
    if (picture.color is not None) != plan.rgb or encoding.depth != wanted.depth or not same_step:
        raise ValueError(f"a picture in {encoding} cannot be written as {wanted}")
    alpha = None
    if plan.layout.alpha:
        top = 2**encoding.depth - 1
        alpha = picture.alpha if picture.alpha is not None else np.full(picture.shape, top, encoding.dtype)
    chroma = picture.chroma
    if plan.layout.planes < 3:
        chroma = None
    elif chroma is None and not plan.rgb:
        shape = wanted.chroma_shape(*picture.shape)
        chroma = (np.full(shape, 2 ** (wanted.depth - 1), wanted.dtype),) * 2
    return replace(
        picture, chroma=chroma, alpha=alpha, encoding=replace(encoding, subsampling=wanted.subsampling)
    )
