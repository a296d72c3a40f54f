"""Frames and targets of a live session."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

from vidstyle.core.picture import Picture
from vidstyle.live.control import Controls
from vidstyle.live.meter import LatencyMeter
from vidstyle.media.capture.monotonic import MONOTONIC, Clock
from vidstyle.media.frame import frame_from_picture

if TYPE_CHECKING:
    import av


@dataclass(frozen=True)
class LiveFrame:
    """A restyled picture on its way to the targets, which share it and only read it.

    Attributes:
        picture: upright, 8 bit, 4:2:0, limited range; always of the size that the session began with.
        captured: capture time in seconds of `time.monotonic`.
        number: from 0; strictly increasing from frame to frame.
        original: the picture before it was restyled; None if it was not kept.
        style: the name of the style that has drawn it.
        undivided: the picture without the comparison with the original; None if it has none.
    """

    picture: Picture
    captured: float
    number: int
    original: Picture | None = None
    style: str = ""
    undivided: Picture | None = None

    @cached_property
    def video(self) -> av.VideoFrame:
        """The picture as a tagged frame in yuv420p, made once for all targets that need one."""
        return frame_from_picture(self.picture)


class Target(Protocol):
    """A place that frames are delivered to.

    Attributes:
        name: as shown to the user, such as "/dev/video9" or "page".
        state: a word or a short phrase, such as "running" or "reconnecting".
    """

    name: str

    @property
    def state(self) -> str:
        """See the class."""

    def offer(self, frame: LiveFrame) -> None:
        """Queue a frame, dropping an older one if need be; never blocks."""

    def close(self) -> None:
        """Release everything; called once, after the last frame."""


@dataclass(frozen=True)
class TargetContext:
    """What a target is opened for: frames like the first, at a rate, with or without sound."""

    first: LiveFrame
    rate: Fraction
    meter: LatencyMeter
    controls: Controls
    sound: bool = False
    clock: Clock = MONOTONIC
