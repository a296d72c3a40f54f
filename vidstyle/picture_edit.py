"""A change of a picture that is made once, in the thread or process that first needs it."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from typing import Any, Generic, TypeVar

from vidstyle.core.kernels import is_dry_run
from vidstyle.core.picture import Picture

Kept = TypeVar("Kept")
Change = Callable[[Picture], tuple[Picture, Kept]]
"""Takes a picture, which it only reads; returns the changed picture, and what it keeps of the original."""
MakeChange = Callable[[Change[Any], Picture], tuple[Picture, Any]]
"""Calls a change, perhaps in another process."""


def make_here(change: Change[Kept], picture: Picture) -> tuple[Picture, Kept]:
    """Call a change in this thread."""
    return change(picture)


class PictureEdit(Generic[Kept]):
    """A changed picture, and data kept of the original; both are made at the first request.

    A dry run of kernels, in which a change is not carried out, neither waits for it nor keeps its result.

    Args:
        source: the picture, or an edit of it that comes before.
        change: can be pickled.

    Attributes:
        change: see Args.
    """

    def __init__(self, source: Picture | PictureEdit[Any], change: Change[Kept]) -> None:
        self._source, self.change, self._lock = source, change, Lock()
        self._result: tuple[Picture, Kept] | None = None

    def picture(self, make: MakeChange = make_here) -> Picture:
        """Return the changed picture; `make` calls the changes that are still to be made."""
        return self._made(make)[0]

    def kept(self) -> Kept:
        """Return the data kept of the original."""
        return self._made(make_here)[1]

    def _made(self, make: MakeChange) -> tuple[Picture, Kept]:
        if is_dry_run():
            return self._make(make_here)
        with self._lock:
            if self._result is None:
                self._result = self._make(make)
            return self._result

    def _make(self, make: MakeChange) -> tuple[Picture, Kept]:
        source = self._source
        picture = source.picture(make) if isinstance(source, PictureEdit) else source
        return make(self.change, picture)
