"""Options of a session, and what its targets are made for."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from vidstyle.live.clock import MONOTONIC, Clock
from vidstyle.live.control import Controls
from vidstyle.live.meter import LatencyMeter
from vidstyle.live.target import LiveFrame
from vidstyle.media.capture.microphone import Microphone


@dataclass(frozen=True)
class LiveOptions:
    """Options of a session.

    Attributes:
        size: of the output; one side may be -1 to keep the aspect ratio, or -2 to be even too.
        rate: frames per second of the targets; None: the source's own.
        device: as for `open_renderer`.
        budget: whether to work at a smaller size when the rate cannot be held otherwise.
        sound: whether to pass sound to the targets that take any.
        microphone: captured in place of the source's own sound, or None.
        frames, seconds: after which to end; None: at the end of the source.
    """

    size: tuple[int, int] | None = None
    rate: Fraction | None = None
    device: str = "auto"
    budget: bool = True
    sound: bool = True
    microphone: Microphone | None = None
    frames: int | None = None
    seconds: float | None = None


@dataclass(frozen=True)
class TargetContext:
    """What a target is opened for: frames like the first, at a rate, with or without sound."""

    first: LiveFrame
    rate: Fraction
    meter: LatencyMeter
    controls: Controls
    sound: bool = False
    clock: Clock = MONOTONIC
