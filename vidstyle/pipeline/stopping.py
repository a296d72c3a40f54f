"""SIGINT, SIGTERM and SIGHUP: the first signal ends the job cleanly, the second exits at once."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn


class StoppedError(BaseException):
    """Raised in the main thread by a signal that ends the program; no exception handler catches it.

    Attributes:
        exit_code: what a shell expects of a program that this signal ended: 129, 130 or 143.
    """

    def __init__(self, cause: signal.Signals) -> None:
        super().__init__(cause)
        self.exit_code = 128 + cause


class Stop(threading.Event):
    """An event that is set to end a job early.

    Attributes:
        exit_code: as in `StoppedError`; 0 if no signal was received.
    """

    exit_code = 0


@contextmanager
def stop_on_signals() -> Iterator[Stop]:
    """Within the block the first signal sets the given event.

    Exiting at the second leaves the file as `kill -9` would: playable, since films are written in fragments.
    """
    stop = Stop()

    def ask(cause: signal.Signals) -> None:
        stop.exit_code = StoppedError(cause).exit_code
        stop.set()

    with on_signals(ask):
        yield stop


def raise_stopped(cause: signal.Signals) -> NoReturn:
    """Raise `StoppedError`."""
    raise StoppedError(cause)


@contextmanager
def on_signals(handle: Callable[[signal.Signals], None]) -> Iterator[None]:
    """Within the block the first SIGINT, SIGTERM or SIGHUP calls `handle`, and a second one exits at once.

    SIGHUP stays ignored where the caller ignores it, as `nohup` does.
    """
    come: list[int] = []

    def take(number: int, _: FrameType | None) -> None:
        if come:
            os._exit(128 + number)
        come.append(number)
        handle(signal.Signals(number))

    numbers = [signal.SIGINT, signal.SIGTERM]
    # Windows has none.
    if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
        numbers.append(signal.SIGHUP)
    before = {number: signal.signal(number, take) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
