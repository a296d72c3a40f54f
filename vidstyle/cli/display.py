"""Progress on standard error: a bar, plain lines or JSON."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from vidstyle.cli.reporting import print_error, say
from vidstyle.pipeline.progress import Progress

KINDS = ("auto", "bar", "plain", "json", "none")
LINE_SECONDS = 3.0
"""The interval between plain lines."""
JSON_SECONDS = 0.5
"""The interval between lines of JSON."""

Show = Callable[[Progress], None]


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
        show_json = _Throttled(JSON_SECONDS, lambda progress: print_error(json.dumps(progress.as_dict())))
        yield show_json
        show_json.show_last()
    else:
        yield lambda progress: None


def position_text(progress: Progress) -> str:
    """Rate, speed and remaining time: "12 fps, 0.5 x, 0:10 left"."""
    left = "" if progress.remaining is None else f", {clock(progress.remaining)} left"
    return f"{progress.rate:.3g} fps, {progress.speed:.2f} x{left}"


def clock(seconds: float) -> str:
    """A duration as [hours:]minutes:seconds.

    >>> clock(3725)
    '1:02:05'
    """
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"


class _Throttled:
    """Calls a function with the progress at most once in an interval."""

    def __init__(self, seconds: float, show: Show) -> None:
        self._seconds, self._show = seconds, show
        self._shown = time.monotonic()
        self._last: Progress | None = None

    def __call__(self, progress: Progress) -> None:
        self._last = progress
        if time.monotonic() - self._shown >= self._seconds:
            self._shown = time.monotonic()
            self._show(progress)

    def show_last(self) -> None:
        if self._last is not None:
            self._show(self._last)


def _print_line(progress: Progress) -> None:
    done = "" if progress.fraction is None else f"{progress.fraction:.0%}, "
    say(f"{done}frame {progress.frames}, {position_text(progress)}")


@contextmanager
def _bar() -> Iterator[Show]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TaskProgressColumn, TextColumn
    from rich.progress import Progress as Bar

    columns = (BarColumn(), TaskProgressColumn(), MofNCompleteColumn(), TextColumn("{task.fields[pace]}"))
    # Messages appear above the bar; standard output may carry the film.
    with Bar(*columns, console=Console(stderr=True), redirect_stdout=False, transient=True) as bar:
        task = bar.add_task("", total=None, pace="")

        def show(progress: Progress) -> None:
            total = progress.frames / progress.fraction if progress.fraction else None
            bar.update(task, completed=progress.frames, total=total, pace=position_text(progress))

        yield show
