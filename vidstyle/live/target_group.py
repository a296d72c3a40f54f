"""All targets of a session as one."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from vidstyle.live.options import TargetContext
from vidstyle.live.summary import Delivery
from vidstyle.live.target import LiveFrame, Target
from vidstyle.live.target_thread import TargetThread
from vidstyle.media.audio import AudioChunk


class TargetGroup:
    """The targets; none of them holds up another."""

    def __init__(self, makers: Sequence[Callable[[TargetContext], Target]]) -> None:
        """`makers`: each makes a target once the first picture tells what it is to take."""
        self._makers = makers
        self._targets: list[Target] = []

    def open(self, setting: TargetContext) -> None:
        """Make them all.

        Raises:
            VidstyleError: one cannot be; those before it are closed by `close`.
        """
        for make in self._makers:
            self._targets.append(make(setting))

    def offer(self, frame: LiveFrame) -> None:
        """Give a frame to each.

        Raises:
            VidstyleError: the last of them has failed.
        """
        for target in self._targets:
            target.offer(frame)
        errors = self._errors()
        if errors and len(errors) == len(self._targets):
            raise errors[0]

    def push_audio(self, chunk: AudioChunk) -> None:
        """Give sound to those that take any; from any thread."""
        for target in self._targets.copy():
            if isinstance(target, TargetThread):
                target.push_audio(chunk)

    def close(self) -> BaseException | None:
        """Let go of all; returns why one has failed, if any has."""
        for target in self._targets:
            target.close()
        return next(iter(self._errors()), None)

    @property
    def states(self) -> tuple[tuple[str, str], ...]:
        """Name and state of each."""
        return tuple((target.name, target.state) for target in self._targets)

    @property
    def deliveries(self) -> tuple[Delivery, ...]:
        """What each got."""
        return tuple(_delivery(target) for target in self._targets)

    @property
    def repeated(self) -> int:
        """Frames that they showed again, together."""
        return sum(delivery.repeated for delivery in self.deliveries)

    def _errors(self) -> list[BaseException]:
        return [error for target in self._targets if (error := getattr(target, "error", None)) is not None]


def _delivery(target: Target) -> Delivery:
    counts = (getattr(target, name, 0) for name in ("delivered", "repeated", "dropped"))
    return Delivery(target.name, target.state, *counts)
