"""Where restyled pictures go, as a running session sees it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import av


@dataclass(frozen=True)
class LiveFrame:
    """A restyled picture on its way out; several targets share it, so it is only read.

    Attributes:
        picture: upright, 8 bit, yuv420p, tagged; always of the size that the session began with.
        captured: when it was taken, in seconds of `time.monotonic`.
        number: of the frame, from 0; each frame that a target is offered has a higher one.
    """

    picture: av.VideoFrame
    captured: float
    number: int


class Target(Protocol):
    """One place to deliver to.

    Attributes:
        name: for people, such as "/dev/video9" or "page".
        state: one word or a short line, such as "running" or "reconnecting".
    """

    name: str

    @property
    def state(self) -> str:
        """How it is."""

    def offer(self, frame: LiveFrame) -> None:
        """Take a frame, or leave it for a newer one; returns at once, whatever the reader does."""

    def close(self) -> None:
        """Let go of everything; called once, after the last frame."""
