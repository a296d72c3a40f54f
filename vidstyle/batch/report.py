"""The result of a batch: counts, an exit code, CSV."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Sequence

from vidstyle.batch.batch_film import BatchFilm, State


def exit_code(films: Sequence[BatchFilm]) -> int:
    """Return the exit code of the first film that failed; else 4 if a source was damaged, else 0."""
    failed = [film.exit_code or 1 for film in films if film.state is State.FAILED]
    return next(iter(failed), max((film.exit_code for film in films), default=0))


def counts_text(films: Sequence[BatchFilm]) -> str:
    """Return the number of films in each state: "12 done, 3 skipped, 1 failed"."""
    counts = Counter(film.state for film in films)
    return ", ".join(f"{counts[state]} {state}" for state in State if counts[state])


def seconds_left(films: Sequence[BatchFilm], elapsed: float) -> float | None:
    """Estimate the remaining time at the speed so far; None without progress.

    Args:
        elapsed: seconds since the start of the batch.
    """
    made = [film for film in films if film.state not in (State.SKIPPED, State.FAILED)]
    whole = sum(film.source_bytes for film in made)
    done = sum(film.source_bytes * (1.0 if film.has_ended else film.fraction or 0.0) for film in made)
    return elapsed * (whole - done) / done if done else None


def csv_text(films: Sequence[BatchFilm]) -> str:
    """Return a table of all films, with a header."""
    text = io.StringIO()
    rows = [film.as_dict() for film in films]
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
