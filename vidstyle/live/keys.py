"""Keys in the terminal, while a session runs."""

from __future__ import annotations

import logging
import os
import select
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from vidstyle.errors import VidstyleError
from vidstyle.live.control import Controls

WAKE_SECONDS = 0.2
STEADY_STEP = 0.1

log = logging.getLogger("vidstyle")

HELP = "n next style, s/S steadier or less, b bypass, p picture, r record, q quit"


@contextmanager
def keys(controls: Controls, descriptor: int | None = None) -> Iterator[bool]:
    """Within the block, single keys steer the session; yields whether there is a terminal to press them in.

    Args:
        descriptor: of the terminal; None: standard input.
    """
    descriptor = _standard_input() if descriptor is None else descriptor
    if (
        descriptor is None
        or os.name != "posix"
        or not os.isatty(descriptor)
        or not _is_foreground(descriptor)
    ):
        yield False
        return
    import termios
    import tty

    before = termios.tcgetattr(descriptor)
    over = threading.Event()
    thread = threading.Thread(
        target=_listen, args=(descriptor, controls, over), name="vidstyle keys", daemon=True
    )
    try:
        tty.setcbreak(descriptor, termios.TCSANOW)
        thread.start()
        yield True
    finally:
        over.set()
        thread.join(2 * WAKE_SECONDS)
        termios.tcsetattr(descriptor, termios.TCSANOW, before)


def press(controls: Controls, key: str) -> None:
    """Do what a key stands for; others do nothing.

    >>> from vidstyle.style import load_style
    >>> controls = Controls(load_style("plain"))
    >>> press(controls, "b")
    >>> controls.bypassed
    True
    """
    actions: dict[str, Callable[[], None]] = {
        "n": controls.next_style,
        "s": lambda: controls.steady(_steadiness(controls) + STEADY_STEP),
        "S": lambda: controls.steady(_steadiness(controls) - STEADY_STEP),
        "b": controls.bypass,
        "p": controls.snapshot,
        "r": controls.record,
        "q": controls.quit,
    }
    if key in actions:
        actions[key]()


def _steadiness(controls: Controls) -> float:
    return float(controls.style.steady)


def _listen(descriptor: int, controls: Controls, over: threading.Event) -> None:
    while not over.is_set():
        if select.select([descriptor], [], [], WAKE_SECONDS)[0]:
            pressed = os.read(descriptor, 64)
            if not pressed:
                return
            for key in pressed.decode("utf-8", "ignore"):
                try:
                    press(controls, key)
                except VidstyleError as error:  # a style file that was spoilt since
                    log.warning("%s", error)


def _standard_input() -> int | None:
    try:
        return sys.stdin.fileno()
    except (OSError, ValueError, AttributeError):  # closed, or not a file at all
        return None


def _is_foreground(descriptor: int) -> bool:
    """A program in the background is stopped by the system if it touches the terminal."""
    try:
        return os.tcgetpgrp(descriptor) == os.getpgrp()
    except OSError:
        return True
