"""All targets of a session together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from vidstyle.live.options import TargetContext
from vidstyle.live.target import LiveFrame, Target
from vidstyle.live.target_thread import TargetThread
from vidstyle.media.audio import AudioChunk


@dataclass(frozen=True)
class Delivery:
    """What one target received: numbers of frames delivered, repeated and dropped."""

    name: str
    state: str
    delivered: int
    repeated: int
    dropped: int

    def __str__(self) -> str:
        counts = f"{self.delivered} delivered, {self.repeated} repeated, {self.dropped} dropped"
        return f"{self.name}: {self.state}, {counts}"


class TargetGroup:
    """Distributes frames and sound to all targets; none of them holds up another."""

    def __init__(self, makers: Sequence[Callable[[TargetContext], Target]]) -> None:
        """`makers`: each makes a target once the first frame is known."""
        self._makers = makers
        self._targets: list[Target] = []

    def open(self, context: TargetContext) -> None:
        """Make all targets.

        Raises:
            VidstyleError: one cannot be opened; `close` closes those before it.
        """
        for make in self._makers:
            self._targets.append(make(context))

    def offer(self, frame: LiveFrame) -> None:
        """Offer a frame to each target.

        Raises:
            VidstyleError: all of them have failed.
        """
        for target in self._targets:
            target.offer(frame)
        errors = self._errors()
        if errors and len(errors) == len(self._targets):
            raise errors[0]

    def push_audio(self, chunk: AudioChunk) -> None:
        """Queue sound at the targets that take any; thread-safe."""
        for target in self._targets.copy():
            if isinstance(target, TargetThread):
                target.push_audio(chunk)

    def close(self) -> BaseException | None:
        """Close all targets; returns the first error of any of them."""
        for target in self._targets:
            target.close()
        return next(iter(self._errors()), None)

    @property
    def states(self) -> tuple[tuple[str, str], ...]:
        """Name and state of each target."""
        return tuple((target.name, target.state) for target in self._targets)

    @property
    def deliveries(self) -> tuple[Delivery, ...]:
        return tuple(
            Delivery(target.name, target.state, *(getattr(target, name, 0) for name in _COUNTS))
            for target in self._targets
        )

    def _errors(self) -> list[BaseException]:
        return [error for target in self._targets if (error := getattr(target, "error", None)) is not None]


_COUNTS = ("delivered", "repeated", "dropped")
