"""Measure how this machine limits a film on several cores."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Sequence

from tools.replay.film_job import FilmTimes

PASS_ROUNDS, BATCH_COUNT = 20, 200


def slowdown(alone: Sequence[FilmTimes], together: Sequence[FilmTimes]) -> float:
    """Return the processor time of a film on several cores, divided by its processor time on one.

    The film itself is measured. Independent films, with one thread each, slow each other less: with their
    slowdown, the replay was 12 and 16 % too fast for `comic` and `watercolor` on two cores.

    Args:
        alone: measurements on one core.
        together: measurements of the same film on several cores.
    """
    least, shared = (min(each.processor / each.frames for each in times) for times in (alone, together))
    return max(1.0, shared / least)


def wake_up_seconds(cores: Sequence[int]) -> float:
    """Return the time to wake a thread on the second core from a thread on the first.

    It is 0 with one core. It is the minimum of several means, as other programs delay threads.
    """
    return min(_mean_pass(cores) for _ in range(BATCH_COUNT)) if len(cores) > 1 else 0.0


def _mean_pass(cores: Sequence[int]) -> float:
    """Return the mean time in which control passes between two threads."""
    permits = threading.Semaphore(0), threading.Semaphore(0)

    def play(own: int, first: bool) -> None:
        os.sched_setaffinity(0, cores[own : own + 1])  # of this thread
        for _ in range(PASS_ROUNDS):
            if first:
                permits[1 - own].release()
            permits[own].acquire()
            if not first:
                permits[1 - own].release()

    threads = [threading.Thread(target=play, args=(own, own == 0)) for own in (0, 1)]
    began = time.perf_counter()
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    return (time.perf_counter() - began) / (2 * PASS_ROUNDS)
