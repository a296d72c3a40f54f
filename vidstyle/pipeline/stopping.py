"""SIGINT, SIGTERM and SIGHUP: the first signal ends the job cleanly, the second exits at once."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class Stop(threading.Event):
    """Set when a job is to end before its end.

    Attributes:
        cause: the signal that asked for it, or None.
    """

    cause: signal.Signals | None = None

    @property
    def exit_code(self) -> int:
        """What a shell expects of a program that this signal ended: 129, 130 or 143."""
        return 128 + (self.cause or 0)


@contextmanager
def stop_on_signals() -> Iterator[Stop]:
    """Within the block SIGINT, SIGTERM and SIGHUP set the given event; a second one exits at once.

    Exiting at once leaves the file as `kill -9` would: playable, since films are written in fragments. SIGHUP
    stays ignored where the caller ignores it, as `nohup` does.
    """
    stop = Stop()

    def ask(number: int, _: FrameType | None) -> None:
        if stop.is_set():
            os._exit(128 + number)
        stop.cause = signal.Signals(number)
        stop.set()

    numbers = [signal.SIGINT, signal.SIGTERM]
    # Windows has none.
    if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
        numbers.append(signal.SIGHUP)
    before = {number: signal.signal(number, ask) for number in numbers}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
