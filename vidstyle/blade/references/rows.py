"""Loops over the rows of a picture on all cores, and what every reference asks of its settings."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from vidstyle.errors import UsageError

MIN_ROWS = 16
"""Fewer rows are not worth a thread."""


def for_all_rows(kernel: Callable[..., None], height: int, *arguments: object) -> None:
    """Call kernel(top, bottom, *arguments) for rows 0..height, divided among the cores.

    The kernel must release the GIL, and write only what belongs to its rows.
    """
    count = min(os.cpu_count() or 1, max(1, height // MIN_ROWS))
    cuts = [height * number // count for number in range(count + 1)]
    with ThreadPoolExecutor(count) as pool:
        strips = [
            pool.submit(kernel, top, bottom, *arguments)
            for top, bottom in zip(cuts[:-1], cuts[1:], strict=True)
        ]
        for strip in strips:
            strip.result()


def require_positive(**lengths: float) -> None:
    """Refuse a length or a time that is not above zero.

    Raises:
        UsageError: names the first.
    """
    for name, value in lengths.items():
        if not 0 < value < float("inf"):
            raise UsageError(name, f"cannot be {value}", "give a number above 0")
