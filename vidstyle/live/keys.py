"""Keyboard control of a session from the terminal."""

from __future__ import annotations

import os
import select
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from vidstyle.errors import VidstyleError, log
from vidstyle.live.control import Controls

POLL_SECONDS = 0.2
KEY_STEADY_STEP = 0.1

KEY_HELP = (
    "n next style, c start the cues, +/- more or less steady, b bypass, s save the picture, r record, q quit"
)


@contextmanager
def keys(controls: Controls, descriptor: int | None = None) -> Iterator[bool]:
    """Within the block, single keys control the session; yields whether there is a terminal.

    Args:
        descriptor: of the terminal; None: standard input.
    """
    try:
        descriptor = sys.stdin.fileno() if descriptor is None else descriptor
    except (OSError, ValueError, AttributeError):  # closed, or not a file at all
        descriptor = -1
    if not _is_foreground_terminal(descriptor):
        yield False
        return
    import termios
    import tty

    before = termios.tcgetattr(descriptor)
    closing = threading.Event()
    thread = threading.Thread(
        target=_listen, args=(descriptor, controls, closing), name="vidstyle keys", daemon=True
    )
    try:
        tty.setcbreak(descriptor, termios.TCSANOW)
        thread.start()
        yield True
    finally:
        closing.set()
        thread.join(2 * POLL_SECONDS)
        termios.tcsetattr(descriptor, termios.TCSANOW, before)


def press(controls: Controls, key: str) -> None:
    """Perform the action of a key; other keys are ignored.

    >>> from vidstyle.style import load_style
    >>> controls = Controls(load_style("plain"))
    >>> press(controls, "b")
    >>> controls.bypassed
    True
    """
    actions: dict[str, Callable[[], None]] = {
        "n": controls.next_style,
        "c": controls.start_cues,
        "+": lambda: controls.steady(controls.style.steady + KEY_STEADY_STEP),
        "-": lambda: controls.steady(controls.style.steady - KEY_STEADY_STEP),
        "b": controls.bypass,
        "s": controls.snapshot,
        "r": controls.record,
        "q": controls.quit,
    }
    if key in actions:
        actions[key]()


def _listen(descriptor: int, controls: Controls, closing: threading.Event) -> None:
    while not closing.is_set():
        if select.select([descriptor], [], [], POLL_SECONDS)[0]:
            pressed = os.read(descriptor, 64)
            if not pressed:
                return
            for key in pressed.decode("utf-8", "ignore"):
                try:
                    press(controls, key)
                except VidstyleError as error:  # a style file that has changed since
                    log.warning("%s", error)


def _is_foreground_terminal(descriptor: int) -> bool:
    """Whether it is a terminal that this process may configure; a background process would be stopped."""
    if os.name != "posix" or not os.isatty(descriptor):
        return False
    try:
        return os.tcgetpgrp(descriptor) == os.getpgrp()
    except OSError:
        return True
