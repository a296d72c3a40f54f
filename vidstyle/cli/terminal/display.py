"""Progress on standard error: a bar, plain lines or JSON."""

from __future__ import annotations

import sys
import textwrap
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from shutil import get_terminal_size
from typing import Any

import click

from vidstyle.cli.parsing.command import option
from vidstyle.cli.terminal.reporting import Reporting, event, say
from vidstyle.pipeline.progress import Progress

KINDS = ("auto", "bar", "plain", "json", "none")
LINE_SECONDS = 3.0
"""The interval between plain lines."""
JSON_SECONDS = 0.5
"""The interval between lines of JSON."""

Show = Callable[[Progress], None]


def progress_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --progress, which with json turns all of standard error to JSON."""

    def choose(context: click.Context, _: click.Parameter, kind: str) -> str:
        if kind == "json" and isinstance(context.obj, Reporting):
            context.obj.as_json = True
        return kind

    text = "Progress report on stderr; json also prints all messages as JSON."
    return option("--progress", type=click.Choice(KINDS), default="auto", callback=choose, help=text)(command)


def list_entry(head: str, text: str) -> str:
    """Return a name and what it is, wrapped under itself on a terminal and on one line elsewhere."""
    if not sys.stdout.isatty():
        return f"{head} {text}".rstrip()
    indent, width = " " * (len(head) + 1), get_terminal_size().columns
    return textwrap.fill(text, width, initial_indent=f"{head} ", subsequent_indent=indent) or head


@contextmanager
def display(kind: str) -> Iterator[Show]:
    """The function that shows progress; `auto` is a bar on a terminal and plain lines elsewhere."""
    if kind == "auto":
        kind = "bar" if sys.stderr.isatty() else "plain"
    if kind == "bar":
        with _bar() as show:
            yield show
    elif kind == "plain":
        yield _Throttled(LINE_SECONDS, _print_line)
    elif kind == "json":
        show_json = _Throttled(JSON_SECONDS, lambda progress: event("progress", progress.as_dict()))
        yield show_json
        show_json.show_last()
    else:
        yield lambda progress: None


class _Throttled:
    """Calls a function with the progress at most once in an interval."""

    def __init__(self, seconds: float, show: Show) -> None:
        self._seconds, self._show = seconds, show
        self._shown = time.monotonic()
        self._last: Progress | None = None

    def __call__(self, progress: Progress) -> None:
        self._last = progress
        if time.monotonic() - self._shown >= self._seconds:
            self.show_last()

    def show_last(self) -> None:
        if self._last is not None:
            self._shown = time.monotonic()
            self._show(self._last)
            self._last = None


def _print_line(progress: Progress) -> None:
    if not progress.frames and not progress.step:
        return  # no progress before the first frame
    done = "" if progress.fraction is None else f"{progress.fraction:.0%}, "
    frame = "" if progress.step else f"frame {progress.frames}, "
    say(f"{done}{frame}{progress.pace_text}")


@contextmanager
def _bar() -> Iterator[Show]:
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn
    from rich.progress import Progress as Bar

    columns = (BarColumn(), TaskProgressColumn(), TextColumn("{task.description}"))
    # Messages appear above the bar; standard output may carry the film.
    with Bar(*columns, console=Console(stderr=True), redirect_stdout=False, transient=True) as bar:
        task = bar.add_task("", total=None)

        def show(progress: Progress) -> None:
            known = progress.fraction is not None
            frames = "" if progress.step else f"{progress.frames} frames, "
            bar.update(
                task,
                completed=progress.fraction or 0,
                total=1 if known else None,
                description=f"{frames}{progress.pace_text}",
            )

        yield show
