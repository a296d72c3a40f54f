"""Opens the program's pages in the user's browser."""

from __future__ import annotations

import os
import sys
import threading
import webbrowser
from collections.abc import Callable
from typing import Any

import click


def open_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """Adds --no-open."""
    return click.option("--no-open", is_flag=True, help="Do not open the page in the browser.")(command)


def is_wanted(no_open: bool) -> bool:
    """Whether somebody sits at a desktop and a terminal, and has not declined."""
    elsewhere = no_open or "CI" in os.environ or "SSH_CONNECTION" in os.environ
    # Without a desktop the browser would be one that runs in the terminal.
    has_desktop = sys.platform in ("darwin", "win32") or {"DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys()
    return bool(has_desktop) and not elsewhere and sys.stdout.isatty() and sys.stderr.isatty()


def open_page(address: str) -> None:
    """Open an address; does not wait, as some browsers take seconds."""
    threading.Thread(target=webbrowser.open, args=(address,), name="vidstyle browser").start()
