"""Loops over the rows of a picture on all cores, and checks of settings."""

from __future__ import annotations

from collections.abc import Callable

from vidstyle.core.bands import in_bands, shared_workers
from vidstyle.errors import UsageError


def for_all_rows(kernel: Callable[..., None], shape: tuple[int, int], *arguments: object) -> None:
    """Call kernel(top, bottom, *arguments) for bands of rows, on all cores.

    The kernel must release the GIL, and write only its rows.
    """
    in_bands(shared_workers(), shape, 0, lambda top, bottom: kernel(top, bottom, *arguments))


def require_positive(**lengths: float) -> None:
    """Check that lengths and times are above zero.

    Raises:
        UsageError: one is not; the error names the first.
    """
    for name, value in lengths.items():
        if not 0 < value < float("inf"):
            raise UsageError(name, f"cannot be {value}", "give a number above 0")
