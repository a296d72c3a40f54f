"""Opens the program's pages in the user's browser."""

from __future__ import annotations

import os
import sys
import threading
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from vidstyle.cli.parsing.command import Group, option
from vidstyle.cli.parsing.common_options import number


def port_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --port."""
    text = "Port of the page.  [default: any free port]"
    return option("--port", type=number(0, 65535, whole=True), default=0, show_default=False,
                  group=Group.CONTROL, help=text)(command)  # fmt: skip


def open_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --no-open."""
    text = "Do not open the page in the browser."
    return option("--no-open", is_flag=True, group=Group.CONTROL, help=text)(command)


def is_wanted(no_open: bool) -> bool:
    """Return whether to open the browser: in a terminal on a desktop, unless the user has declined."""
    elsewhere = no_open or "CI" in os.environ or "SSH_CONNECTION" in os.environ
    # Without a desktop, a text browser would start in the terminal.
    has_desktop = sys.platform in ("darwin", "win32") or {"DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys()
    return bool(has_desktop) and not elsewhere and sys.stdout.isatty() and sys.stderr.isatty()


def open_page(address: str) -> None:
    """Open an address; does not wait, as some browsers take seconds."""
    threading.Thread(target=webbrowser.open, args=(address,), name="vidstyle browser").start()


def show_in_folder(path: Path) -> None:
    """Show a file in the program for folders."""
    click.launch(str(path), locate=True)
