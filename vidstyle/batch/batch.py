"""Renders the films of a batch: runs a process for each film and records the results."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from vidstyle.batch.batch_film import BatchFilm, State
from vidstyle.batch.division import Division, is_taken, remove_scratch
from vidstyle.batch.film_checks import FINISHED, check_target, parts_of, source_signature
from vidstyle.batch.journal import Parts
from vidstyle.batch.processes import Event, Executor, Outcome
from vidstyle.batch.stored_path import StoredPath, argument_of
from vidstyle.errors import InputError, UsageError, VidstyleError, output_error
from vidstyle.media.options import WriteOptions
from vidstyle.media.write.run_record import is_being_written
from vidstyle.media.write.writer import is_resumable
from vidstyle.pipeline.render import DAMAGED_EXIT_CODE

POLL_SECONDS = 0.2
"""Interval at which progress is shown and idle threads check for work."""
FINAL_CODES = (UsageError.exit_code, InputError.exit_code)
"""Exit codes of failures that another attempt would repeat."""


@dataclass(frozen=True)
class BatchOptions:
    """How to run a batch.

    Attributes:
        jobs: number of parallel processes.
        threads: number of threads of each process.
        words: command line options of `render` for all films.
        overwrite: whether to replace a target that is not a finished result of this film.
        retry: number of further attempts for a film that failed.
        every: minimum length of a segment, as text; None: films are not divided.
    """

    jobs: int
    threads: int
    words: Sequence[str] = ()
    overwrite: bool = False
    retry: int = 0
    every: str | None = None


class FilmBatch:
    """Films that `run` renders in parallel.

    Args:
        films: films to render, in this order.
        processes: runs the processes of the films.
        on_notice: called with a film and a notice of its process, from any thread.
        on_end: called with each film at its end, from any thread.

    Attributes:
        films: all films, with their states.
    """

    def __init__(
        self,
        films: Iterable[BatchFilm],
        options: BatchOptions,
        processes: Executor,
        on_notice: Callable[[BatchFilm, str], None] = lambda film, text: None,
        on_end: Callable[[BatchFilm], None] = lambda film: None,
    ) -> None:
        self.films = list(films)
        self._options, self._on_notice, self._on_end = options, on_notice, on_end
        self._processes = processes
        self._lock, self._slots = threading.Lock(), threading.Semaphore(options.jobs)
        self._is_open = False
        self._error: Exception | None = None

    def run(
        self,
        stop: threading.Event,
        watch: Callable[[], None],
        more: Callable[[], Iterable[BatchFilm]] | None = None,
    ) -> None:
        """Render all films; when `stop` is set, close the films in progress.

        Args:
            watch: called several times per second from this thread.
            more: called in the same way; returns further films. With it, only `stop` ends the batch.

        Raises:
            Exception: a bug, in any thread; a film that fails raises no exception.
        """
        self._is_open = more is not None
        self._checked(self.films)
        threads = [
            threading.Thread(target=self._guard, name=f"vidstyle batch {number}", daemon=True)
            for number in range(self._options.jobs)
        ]
        for thread in threads:
            thread.start()
        try:
            while any(thread.is_alive() for thread in threads) and not stop.wait(POLL_SECONDS):
                if more is not None:
                    self.films += self._checked(more())
                watch()
        finally:
            self._processes.stop()
            for thread in threads:
                thread.join()
        for film in self.films:
            if not film.has_ended:
                film.end(State.STOPPED)
        watch()
        if self._error is not None:
            raise self._error

    def _checked(self, films: Iterable[BatchFilm]) -> list[BatchFilm]:
        """Report the films whose look could not be read, and return all."""
        films = list(films)
        for film in films:
            if film.has_ended:
                self._on_end(film)
        return films

    def _guard(self) -> None:
        try:
            self._work()
        except Exception as error:  # a thread's error is raised again in the calling thread
            self._error = error
            self._processes.stop()

    def _work(self) -> None:
        while not self._processes.is_stopped:
            film = self._take()
            if film is not None:
                self._attempt(film)
                if film.has_ended:
                    self._on_end(film)
            elif self._is_open or any(each.state is State.ELSEWHERE for each in self.films):
                time.sleep(POLL_SECONDS)
            else:
                return

    def _take(self) -> BatchFilm | None:
        """Return the next film that is not in progress, here or in another batch."""
        with self._lock:
            for film in self.films:
                is_free = film.state is State.ELSEWHERE and not self._is_elsewhere(film)
                if is_free or film.state is State.WAITING:
                    film.state = State.READING
                    return film
        return None

    def _attempt(self, film: BatchFilm) -> None:
        try:
            self._make(film)
        except InterruptedError:
            film.end(State.STOPPED)
        except BlockingIOError:
            film.end(State.ELSEWHERE)
        except OSError as error:
            failure = error if isinstance(error, VidstyleError) else output_error(film.target, error)
            film.end(State.FAILED, str(failure), failure.exit_code)
        except VidstyleError as error:
            film.end(State.FAILED, str(error), error.exit_code)

    def _make(self, film: BatchFilm) -> None:
        # In this order: another batch may end its work between the two checks.
        is_elsewhere, parts = self._is_elsewhere(film), parts_of(film, lambda: self._processes.is_stopped)
        if is_elsewhere:
            film.state = State.ELSEWHERE
        elif film.journal.is_finished(film.target, parts):
            film.end(State.SKIPPED, FINISHED)
            if self._options.every is not None and not isinstance(film.target, StoredPath):
                # A batch was killed before it removed them.
                remove_scratch(film.target)
        else:
            copies = 1 if self._options.every is None else 2  # segments, and the film that joins them
            check_target(film, parts, self._options.overwrite, self.films, copies)
            film.begin()
            film.journal.begin(film.target, parts)
            before = source_signature(film)
            outcome = self._render(film) if self._options.every is None else self._divide(film, parts)
            self._end(film, parts, outcome, source_signature(film) != before)

    def _is_elsewhere(self, film: BatchFilm) -> bool:
        """Whether another batch renders this film; of a film in storage, its process finds out."""
        if isinstance(film.target, StoredPath):
            return False
        is_divided = self._options.every is not None
        return is_being_written(film.target) or (is_divided and is_taken(film.target))

    def _is_made_elsewhere(self, film: BatchFilm) -> bool:
        """Whether another batch renders this film, or has just ended; of one in storage, nobody knows."""
        if isinstance(film.target, StoredPath):
            return False
        return self._is_elsewhere(film) or (film.target.exists() and not self._options.overwrite)

    def _render(self, film: BatchFilm) -> Outcome:
        """Render a film in one process."""
        replaces = self._options.overwrite or not is_resumable(str(film.target), WriteOptions())
        words = ["render", *film_words(film, self._options), "--overwrite" if replaces else "--resume"]
        return self._run(words, film, film.follow)

    def _divide(self, film: BatchFilm, parts: Parts) -> Outcome:
        """Render a film in segments, or in one process if it cannot be divided."""
        assert self._options.every is not None
        settings = {**parts, "threads": str(self._options.threads)}
        division = Division(film, settings, self._options.every, self._options.jobs)
        words = film_words(film, self._options) + ["--overwrite"] * self._options.overwrite
        with division.locked():
            outcome = division.make(words, lambda words, follow: self._run(words, film, follow))
            outcome = outcome or self._render(film)
            if is_done(outcome.exit_code) or outcome.exit_code in FINAL_CODES:
                division.remove()
        return outcome

    def _end(self, film: BatchFilm, parts: Parts, outcome: Outcome, is_changed: bool) -> None:
        """Record the outcome of a film's processes; `is_changed`: whether its source has changed."""
        code = outcome.exit_code
        if is_done(code) and is_changed:
            film.target.unlink(missing_ok=True)
            raise InputError(film.source.path, "was changed while it was read", "run the batch again")
        if is_done(code):
            film.journal.finish(film.target, parts, film.source.path)
            film.end(State.DONE, outcome.summary.get("damage", ""), code)
            return
        if isinstance(film.target, StoredPath):
            film.journal.abandon(film.target, parts)
        if self._processes.is_stopped:
            film.end(State.STOPPED)
        elif self._is_made_elsewhere(film):
            film.end(State.ELSEWHERE)
        else:
            may_retry = code not in FINAL_CODES and film.attempts <= self._options.retry
            film.end(State.WAITING if may_retry else State.FAILED, outcome.error, code)

    def _run(self, words: list[str], film: BatchFilm, follow: Callable[[Event], None]) -> Outcome:
        """Run a process of a film, as soon as the limit of parallel processes allows."""

        def take(event: Event) -> None:
            if event["event"] in ("progress", "summary"):
                follow(event)
            elif event["event"] == "notice":
                self._on_notice(film, event.get("text", ""))

        with self._slots:
            return self._processes.run(words, take, self._options.threads)


def film_words(film: BatchFilm, options: BatchOptions) -> list[str]:
    """Return the options of a film's processes: its input, and everything that determines its result."""
    return [
        f"--input={argument_of(film.source.path)}",
        f"--output={argument_of(film.target)}",
        f"{film.option}={film.style}",
        *options.words,
        f"--threads={options.threads}",
        "--log-level=warning",
    ]


def is_done(exit_code: int) -> bool:
    """Whether a process has completed its result."""
    return exit_code in (0, DAMAGED_EXIT_CODE)
