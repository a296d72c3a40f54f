"""What a session is told at its beginning, and what it tells its targets."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from vidstyle.live.control import Controls
from vidstyle.live.meter import Meter
from vidstyle.live.target import LiveFrame
from vidstyle.media.capture.microphone import Microphone


@dataclass(frozen=True)
class LiveOptions:
    """How to run.

    Attributes:
        size: of the pictures that go out; one side may be -1 to keep the shape, or -2 to be even too.
        rate: frames per second that targets show; None: the source's own.
        device: as for `open_renderer`.
        budget: whether to work on smaller pictures when the rate cannot be held otherwise.
        sound: whether to pass on sound where a target takes any.
        microphone: what is heard in place of the source's own sound, or None.
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
    """What a target is made for: pictures like the first, so many a second, with or without sound."""

    first: LiveFrame
    rate: Fraction
    meter: Meter
    controls: Controls
    sound: bool = False
