"""vidstyle open: a page to restyle films and photographs without a terminal."""

from __future__ import annotations

import itertools
import re
import threading
from collections.abc import Callable
from pathlib import Path

import click

from vidstyle.cli import browser
from vidstyle.cli.parsing import common_options as common
from vidstyle.cli.parsing.child_pages import ChildPages
from vidstyle.cli.parsing.command import command
from vidstyle.cli.terminal.reporting import reporting_options, say
from vidstyle.errors import UsageError


@command(
    "Restyle films and photographs on a page in the browser.",
    examples=("vidstyle open", "vidstyle open holiday.mp4"),
)
@click.argument("source", metavar="[INPUT]", required=False)
@browser.port_option
@browser.open_option
@common.device_option()
@reporting_options
def open(source: str | None, port: int, no_open: bool, device: str) -> int:  # noqa: A001
    """Restyle films and photographs on a page: drop a file, choose a look, adjust it, and render.

    Without INPUT the page waits for a file. Rendered files are saved in the current folder. In a desktop
    terminal, `vidstyle` without a command does the same. Press Ctrl-C to stop.
    """
    from vidstyle.pipeline.stopping import stop_on_signals

    with stop_on_signals() as stop:
        show_front_page(source, port, no_open, device, stop)
    return stop.exit_code


def show_front_page(source: str | None, port: int, no_open: bool, device: str, stop: threading.Event) -> None:
    """Serve the page until `stop` is set."""
    from vidstyle.design import serve
    from vidstyle.design.front_door import FrontDoor

    is_wanted = browser.is_wanted(no_open)
    with ChildPages() as children:
        pages = {
            "explore": lambda file, _: children.open(["explore", file or "camera"]),
            "sheet": lambda file, report: _make_sheet(children, file, report),
            "comic": lambda file, report: _make_comic(children, file, ".html", report),
            "print": lambda file, report: _make_comic(children, file, ".pdf", report, is_wanted),
            "live": lambda file, _: _show_live(children, "camera"),
            "live-film": lambda file, _: _show_live(children, file or "test"),
            "live-test": lambda file, _: _show_live(children, "test"),
        }
        reveal = browser.show_in_folder if is_wanted else None
        front = FrontDoor(pages, reveal, children.cancel)
        browse = browser.open_page if is_wanted else None
        for url in serve(source, None, Path.cwd(), port, device, browse, stop, front):
            say(f"page: {url}")


def _show_live(children: ChildPages, source: str) -> str:
    return children.open(["live", source, "--style", "ink", "--to", "page"])


def _make_comic(
    children: ChildPages, file: str | None, suffix: str, report: Callable[[str], None], is_shown: bool = False
) -> str:
    """Make comic pages of a film in the current folder; return the path of the file.

    Args:
        children: runs the command.
        file: the film.
        suffix: of the file that is made.
        report: called with the progress in words.
        is_shown: whether to open it in the program for its type.
    """
    if file is None:
        raise UsageError("comic pages", "need a film", "open one first")
    path = _free_path(file, f"comic-{{}}{suffix}")
    children.run(["comic", file, str(path)], report)
    if is_shown:
        click.launch(str(path))
    return str(path)


def _make_sheet(children: ChildPages, file: str | None, report: Callable[[str], None]) -> str:
    """Make a page with a picture, or a frame of a film, in all looks; return the path of the file."""
    if file is None:
        raise UsageError("a sheet of looks", "needs a film or a photograph", "open one first")
    path = _free_path(file, "looks-{}.html")
    children.run(["styles", "--preview", file, "-o", str(path), "--no-open"], report)
    return str(path)


def _free_path(file: str, ending: str) -> Path:
    """Return the path of a new file in the current folder, named after another one.

    Args:
        file: the other file.
        ending: of the name, with {} for a number.
    """
    stem = re.sub(r"[^\w-]+", "-", Path(file).stem) or "film"
    paths = (Path.cwd() / f"{stem}-{ending.format(number)}" for number in itertools.count(1))
    return next(path for path in paths if not path.exists())
