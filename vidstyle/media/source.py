"""What films, picture sequences and animations have in common once they are decoded."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol

import av

from vidstyle.media.damage import Damage
from vidstyle.media.orientation import Orientation


@dataclass(frozen=True)
class Stamped:
    """A decoded frame, as stored, and when it is shown.

    Attributes:
        pts, duration: in the source's time base.
        held: whether it stands for one that could not be decoded.
    """

    native: av.VideoFrame
    pts: int
    duration: int | None = None
    key: bool = False
    held: bool = False


class Source(Protocol):
    """Decoded frames in the order that they are shown in, with packets of other streams among them."""

    name: str
    codec: str
    time_base: Fraction
    rate: Fraction | None
    sample_aspect: Fraction | None
    duration: Fraction | None
    frames: int | None
    may_be_still: bool
    orientation: Orientation | None
    damage: Damage
    container: av.container.InputContainer | None
    copied_streams: list[av.stream.Stream]

    def seek(self, time: Fraction) -> None:
        """Continue from a key frame at or before a time in seconds, where that can be done."""

    def items(self) -> Iterator[Stamped | av.Packet]:
        """Everything from here to the end."""

    def close(self) -> None:
        """Let go of the files."""
