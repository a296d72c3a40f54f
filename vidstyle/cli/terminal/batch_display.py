"""The progress of a batch on standard error, and the table of its results."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from vidstyle.batch.batch_film import BatchFilm, State
from vidstyle.batch.report import counts_text, seconds_left
from vidstyle.cli.terminal.display import JSON_SECONDS, LINE_SECONDS
from vidstyle.cli.terminal.reporting import event, say
from vidstyle.errors import printable
from vidstyle.pipeline.progress import clock

if TYPE_CHECKING:
    from rich.console import Group
    from rich.live import Live

MAX_ROWS = 20
"""The most films under way in the live table."""


class BatchDisplay:
    """Reports what fails or ends, and sometimes how far the batch is.

    Args:
        seconds: interval between two reports of progress; None: no such reports.
    """

    def __init__(self, seconds: float | None) -> None:
        self._seconds, self._shown, self._text = seconds, time.monotonic(), ""

    def notice(self, film: BatchFilm, text: str) -> None:
        """Report a notice of a film's process."""
        name = printable(film.source.path)
        say(text if text.startswith(name) else f"{name}: {text}")

    def end(self, film: BatchFilm, films: Sequence[BatchFilm]) -> None:
        """Report that a film has ended."""
        ended = sum(each.has_ended for each in films)
        if film.state is not State.STOPPED:
            event("film", film.as_dict(), f"{film_text(film)} ({ended} of {len(films)})")

    def update(self, films: Sequence[BatchFilm], elapsed: float) -> None:
        """Report progress, if it is time; `elapsed`: seconds since the batch began."""
        if self._seconds is None or time.monotonic() - self._shown < self._seconds:
            return
        self._shown = time.monotonic()
        running = [film.as_dict() for film in films if film.state is State.RUNNING]
        before, self._text = self._text, total(films, elapsed)
        if running or self._text != before:  # a watched folder may get nothing for days
            event("progress", {"running": running, **progress_facts(films, elapsed)}, self._text)


class QuietDisplay(BatchDisplay):
    """Reports only notices and failures."""

    def end(self, film: BatchFilm, films: Sequence[BatchFilm]) -> None:
        """See BatchDisplay."""
        if film.state is State.FAILED:
            super().end(film, films)


class LiveTable(BatchDisplay):
    """A table of the films under way; other messages appear above it."""

    def __init__(self, live: Live) -> None:
        super().__init__(None)
        self._live = live

    def update(self, films: Sequence[BatchFilm], elapsed: float) -> None:
        """See BatchDisplay."""
        self._live.update(live_table(films, elapsed), refresh=True)


@contextmanager
def batch_display(kind: str) -> Iterator[BatchDisplay]:
    """The display of this kind; see `display`."""
    if kind == "auto":
        kind = "bar" if sys.stderr.isatty() else "plain"
    if kind == "bar":
        from rich.console import Console
        from rich.live import Live

        console = Console(stderr=True)
        with Live(console=console, auto_refresh=False, transient=True, redirect_stdout=False) as live:
            yield LiveTable(live)
    elif kind == "none":
        yield QuietDisplay(None)
    else:
        yield BatchDisplay(JSON_SECONDS if kind == "json" else LINE_SECONDS)


def live_table(films: Sequence[BatchFilm], elapsed: float) -> Group:
    """Return a table of the films under way, with state, progress, frames per second and time left."""
    from rich.console import Group
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None)
    for title in ("film", "style", "state", "", "fps", "left"):
        table.add_column(title, justify="right" if title in ("fps", "left") else "left")
    shown = [film for film in films if film.state in (State.READING, State.RUNNING, State.ELSEWHERE)]
    for film in shown[:MAX_ROWS]:
        done = "" if film.fraction is None else f"{film.fraction:.0%}"
        left = "" if film.remaining is None else clock(film.remaining)
        pace = f"{film.fps:.3g}" if film.fps else ""
        cells = [printable(film.source.path.name), film.style, film.state, done, pace, left]
        table.add_row(*map(Text, cells))  # names may contain what rich takes for markup
    return Group(table, Text(total(films, elapsed))) if shown else Group(Text(total(films, elapsed)))


def progress_facts(films: Sequence[BatchFilm], elapsed: float) -> dict[str, Any]:
    """Return the progress of all films in plain values."""
    left = seconds_left(films, elapsed)
    return {
        "ended": sum(film.has_ended for film in films),
        "films": len(films),
        "fps": round(sum(film.fps for film in films if film.state is State.RUNNING), 2),
        "eta": None if left is None else round(left, 1),
    }


def total(films: Sequence[BatchFilm], elapsed: float) -> str:
    """Return the progress of all films in a line."""
    facts = progress_facts(films, elapsed)
    pace = f": {facts['fps']:.3g} fps" if facts["fps"] else ""
    left = f", {clock(facts['eta'])} left" if facts["eta"] else ""
    return f"{counts_text(films)}{pace}{left}"


def film_text(film: BatchFilm) -> str:
    """Return how a film has ended, in a line."""
    if film.state is State.FAILED:
        return printable(film.reason)
    if film.state is State.SKIPPED:
        return f"{printable(film.target)}: skipped, it {film.reason}"
    damage = f"; {printable(film.reason)}" if film.reason else ""
    return f"{printable(film.target)}: {film.frames} frames in {clock(film.seconds)}{damage}"


def summary_table(films: Sequence[BatchFilm]) -> list[str]:
    """Return the lines of a table of all films."""
    rows = [("state", "frames", "fps", "time", "result")]
    for film in films:
        name = printable(film.target)
        pace = (str(film.frames), f"{film.fps:.1f}", clock(film.seconds)) if film.seconds else ("", "", "")
        says_name = film.reason.startswith(name)
        result = film.reason if says_name else f"{name}: {film.reason}" if film.reason else name
        rows.append((film.state, *pace, printable(result)))
    widths = [max(len(row[column]) for row in rows) for column in range(4)]
    return [
        "  ".join([state.ljust(widths[0]), *map(str.rjust, numbers, widths[1:]), result])
        for state, *numbers, result in rows
    ]
