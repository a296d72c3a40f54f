"""Loops over the rows of a picture on all cores, and what every reference asks of its settings."""

from __future__ import annotations

from collections.abc import Callable

from vidstyle.core.bands import in_bands, shared_pool
from vidstyle.errors import UsageError


def for_all_rows(kernel: Callable[..., None], shape: tuple[int, int], *arguments: object) -> None:
    """Call kernel(top, bottom, *arguments) for bands of rows, on all cores.

    The kernel must release the GIL, and write only what belongs to its rows.
    """
    in_bands(shared_pool(), shape, 0, lambda top, bottom: kernel(top, bottom, *arguments))


def require_positive(**lengths: float) -> None:
    """Refuse a length or a time that is not above zero.

    Raises:
        UsageError: names the first.
    """
    for name, value in lengths.items():
        if not 0 < value < float("inf"):
            raise UsageError(name, f"cannot be {value}", "give a number above 0")
